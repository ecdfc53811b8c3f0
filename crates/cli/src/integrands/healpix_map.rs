//! HEALPix maps in FITS files.

use std::path::Path;

use sphvar_healpix::{Nested, Nside};
use sphvar_integrands::{HealpixMap, HealpixMapParameters, MissingPixels};

use crate::error::CliError;
use crate::files::FitsMap;
use crate::session::Session;

/// Reads the map of a file.
pub(super) fn read(
    wanted: &HealpixMapParameters,
    session: &Session,
    remarks: &mut Vec<String>,
) -> Result<HealpixMap, CliError> {
    let (hdu, field) = (wanted.hdu.as_deref(), wanted.field.as_deref());
    let (path, read) = session.read_map(&wanted.file, hdu, field)?;
    map(&path, read, wanted.missing, remarks)
}

/// Returns the map, converted to ring order if it is nested.
fn map(
    path: &Path,
    mut map: FitsMap,
    missing: MissingPixels,
    remarks: &mut Vec<String>,
) -> Result<HealpixMap, CliError> {
    let system = map.coordinates.map_or(String::new(), |c| format!(" (COORDSYS {c})"));
    let failed =
        |e: &dyn std::fmt::Display| CliError::File(format!("{}{system}: {e}", path.display()));
    let count = map.values.iter().filter(|value| !HealpixMap::is_value(**value)).count();
    if count > 0 {
        let (filling, words) = match missing {
            MissingPixels::Error => {
                let first = map.values.iter().position(|value| !HealpixMap::is_value(*value));
                return Err(failed(&format!(
                    "{count} pixels of the map have no value (NaN, infinite, UNSEEN or absent), the first \
                     is {} of {} in its order; missing=0 or missing=mean fills them",
                    first.unwrap_or(0),
                    map.values.len(),
                )));
            }
            MissingPixels::Zero => (0.0, "0".to_owned()),
            MissingPixels::Mean => {
                let values = map.values.iter().filter(|value| HealpixMap::is_value(**value));
                let mean = values.sum::<f64>() / (map.values.len() - count) as f64;
                (mean, format!("the mean {mean} of the others"))
            }
        };
        if !f64::is_finite(filling) {
            return Err(failed(&"no pixel has a value, so the mean is undefined"));
        }
        for value in map.values.iter_mut().filter(|value| !HealpixMap::is_value(**value)) {
            *value = filling;
        }
        remarks.push(format!(
            "{}: {count} of {} pixels have no value and are replaced by {words}",
            path.display(),
            map.values.len()
        ));
    }
    let nside = Nside::new(map.nside).map_err(|e| failed(&e))?;
    if map.nested {
        let order = Nested::new(nside).map_err(|e| failed(&e))?;
        HealpixMap::from_nested(order, map.values).map_err(|e| failed(&e))
    } else {
        HealpixMap::new(nside, map.values).map_err(|e| failed(&e))
    }
}
