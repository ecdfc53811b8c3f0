//! Single integrands: a name with parameters.

use std::io::Cursor;
use std::path::Path;

use sphvar_healpix::{Nested, Nside};
use sphvar_variance::{
    AbsCosine, Cap, ClampedCosine, DoubleCap, EnvironmentMap, Harmonic, HealpixMap, Integrand,
    PhongLobe, VonMisesFisher,
};

use crate::error::CliError;
use crate::files::{Channel, decode_image, read_fits_map, read_image};
use crate::memory::check_degree;
use crate::spec::{Spec, unknown_name};

/// All names.
const NAMES: [&str; 10] = [
    "ylm",
    "cap",
    "double-cap",
    "half-space",
    "vmf",
    "phong",
    "cosine",
    "abs-cosine",
    "env",
    "map",
];

/// The integrand of one specification.
pub(super) fn parse(text: &str) -> Result<Box<dyn Integrand>, CliError> {
    let mut spec = Spec::parse(text)?;
    let wrong = |error: sphvar_variance::Error| CliError::Usage(format!("{text}: {error}"));
    let (function, keys): (Box<dyn Integrand>, &[&str]) = match spec.name.as_str() {
        "ylm" => {
            let l = spec.require_number("l")?;
            let m = spec.take_number("m")?.unwrap_or(0);
            check_degree(text, l)?;
            (Box::new(Harmonic::new(l, m).map_err(wrong)?), &["l", "m"])
        }
        "cap" => {
            let degrees = spec.require_number("degrees")?;
            (Box::new(Cap::from_degrees(degrees).map_err(wrong)?), &["degrees"])
        }
        "double-cap" => {
            let degrees = spec.require_number("degrees")?;
            (Box::new(DoubleCap::from_degrees(degrees).map_err(wrong)?), &["degrees"])
        }
        "half-space" => {
            let height = spec.take_number("height")?.unwrap_or(0.0);
            (Box::new(Cap::half_space(height).map_err(wrong)?), &["height"])
        }
        "vmf" => {
            let kappa = spec.require_number("kappa")?;
            (Box::new(VonMisesFisher::new(kappa).map_err(wrong)?), &["kappa"])
        }
        "phong" => {
            let exponent = spec.require_number("n")?;
            (Box::new(PhongLobe::new(exponent).map_err(wrong)?), &["n"])
        }
        "cosine" => (Box::new(ClampedCosine), &[]),
        "abs-cosine" => (Box::new(AbsCosine), &[]),
        "env" => {
            let file = file(&mut spec, text)?;
            let channel = channel(&mut spec)?;
            (Box::new(environment(Path::new(&file), channel)?), &["file", "channel"])
        }
        "map" => {
            let file = file(&mut spec, text)?;
            let field = spec.take_number("field")?.unwrap_or(0);
            (Box::new(healpix_map(Path::new(&file), field)?), &["file", "field"])
        }
        name => return Err(unknown_name("integrand", name, &NAMES)),
    };
    spec.finish(keys)?;
    Ok(function)
}

fn file(spec: &mut Spec, text: &str) -> Result<String, CliError> {
    let name = spec.name.clone();
    spec.take("")
        .or_else(|| spec.take("file"))
        .ok_or_else(|| CliError::Usage(format!("{text}: the file is missing: {name}:FILE")))
}

fn channel(spec: &mut Spec) -> Result<Channel, CliError> {
    match spec.take("channel").as_deref() {
        None | Some("luminance") => Ok(Channel::Luminance),
        Some("r") => Ok(Channel::Red),
        Some("g") => Ok(Channel::Green),
        Some("b") => Ok(Channel::Blue),
        Some(other) => Err(unknown_name("channel", other, &["luminance", "r", "g", "b"])),
    }
}

/// The light probe of the examples, for those who have no clone of the repository.
const CITY: &[u8] = include_bytes!("../../../../data/city.exr");

fn environment(path: &Path, channel: Channel) -> Result<EnvironmentMap, CliError> {
    let image = if path == Path::new("data/city.exr") && !path.exists() {
        decode_image(Cursor::new(CITY), path, channel)?
    } else {
        read_image(path, channel)?
    };
    EnvironmentMap::new(image.width, image.height, image.values)
        .map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
}

/// The map of a FITS file, brought to ring order if it says that it is nested.
fn healpix_map(path: &Path, field: usize) -> Result<HealpixMap, CliError> {
    let map = read_fits_map(path, field)?;
    let system = map.coordinates.map_or(String::new(), |c| format!(" (COORDSYS {c})"));
    let failed =
        |e: &dyn std::fmt::Display| CliError::Failed(format!("{}{system}: {e}", path.display()));
    let nside = Nside::new(map.nside).map_err(|e| failed(&e))?;
    if map.nested {
        let order = Nested::new(nside).map_err(|e| failed(&e))?;
        HealpixMap::from_nested(order, map.values).map_err(|e| failed(&e))
    } else {
        HealpixMap::new(nside, map.values).map_err(|e| failed(&e))
    }
}
