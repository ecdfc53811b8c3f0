//! HEALPix maps in FITS files.

use std::path::Path;

use sphvar_healpix::{Nested, Nside};
use sphvar_integrands::HealpixMap;

use crate::error::CliError;
use crate::files::{FitsField, FitsMap, HduChoice, read_fits_map};
use crate::spec::Spec;

/// The parameters of a map besides its file.
pub(crate) const KEYS: [&str; 3] = ["field", "hdu", "missing"];

/// What becomes of pixels without a value.
#[derive(Clone, Copy)]
enum Missing {
    Error,
    Zero,
    /// The mean of the others.
    Mean,
}

/// Reads the map of a file with the parameters [`KEYS`] of a specification.
pub(super) fn take(
    spec: &mut Spec,
    file: &Path,
    remarks: &mut Vec<String>,
) -> Result<HealpixMap, CliError> {
    let field = match spec.take("field") {
        None => FitsField::Number(0),
        Some(text) => FitsField::Name(text),
    };
    let (path, mut hdu) = HduChoice::of_path(file);
    if let Some(text) = spec.take("hdu") {
        hdu = text.parse().map_err(|e| CliError::Usage(format!("{}: hdu: {e}", spec.text)))?;
    }
    let mut missing = Missing::Error;
    spec.replace_choice("missing", &[("0", Missing::Zero), ("mean", Missing::Mean)], &mut missing)?;
    map(&path, read_fits_map(&path, &hdu, &field)?, missing, remarks)
}

/// Returns the map, brought to ring order if it says that it is nested.
fn map(
    path: &Path,
    mut map: FitsMap,
    missing: Missing,
    remarks: &mut Vec<String>,
) -> Result<HealpixMap, CliError> {
    let system = map.coordinates.map_or(String::new(), |c| format!(" (COORDSYS {c})"));
    let failed =
        |e: &dyn std::fmt::Display| CliError::Failed(format!("{}{system}: {e}", path.display()));
    let count = map.values.iter().filter(|value| !HealpixMap::is_value(**value)).count();
    if count > 0 {
        let (filling, words) = match missing {
            Missing::Error => {
                let first = map.values.iter().position(|value| !HealpixMap::is_value(*value));
                return Err(failed(&format!(
                    "{count} of the map's pixels have no value (NaN, infinite, UNSEEN or absent), the first \
                     is {} of {} in its order; missing=0 or missing=mean fills them",
                    first.unwrap_or(0),
                    map.values.len(),
                )));
            }
            Missing::Zero => (0.0, "0".to_owned()),
            Missing::Mean => {
                let values = map.values.iter().filter(|value| HealpixMap::is_value(**value));
                let mean = values.sum::<f64>() / (map.values.len() - count) as f64;
                (mean, format!("the mean {mean} of the others"))
            }
        };
        if !f64::is_finite(filling) {
            return Err(failed(&"no pixel has a value: there is no mean"));
        }
        for value in map.values.iter_mut().filter(|value| !HealpixMap::is_value(**value)) {
            *value = filling;
        }
        remarks.push(format!(
            "{}: {count} of {} pixels have no value and are taken for {words}",
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
