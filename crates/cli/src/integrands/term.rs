//! Single integrands: a name with parameters.

use std::path::PathBuf;

use sphvar_integrands::{
    AbsCosine, Cap, ClampedCosine, DoubleCap, Harmonic, Integrand, PhongLobe, VonMisesFisher,
};

use super::environment::{self, Environment};
use super::healpix_map;
use crate::error::CliError;
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

/// The integrand of one specification; what a user should know of its file goes to `remarks`.
pub(super) fn parse(text: &str, remarks: &mut Vec<String>) -> Result<Box<dyn Integrand>, CliError> {
    let mut spec = Spec::parse(text)?;
    let wrong = |error: sphvar_integrands::Error| CliError::Usage(format!("{text}: {error}"));
    let (function, keys): (Box<dyn Integrand>, Vec<&str>) = match spec.name.as_str() {
        "ylm" => {
            let l = spec.require_number("l")?;
            let m = spec.take_number("m")?.unwrap_or(0);
            check_degree(text, l)?;
            (Box::new(Harmonic::new(l, m).map_err(wrong)?), vec!["l", "m"])
        }
        "cap" => {
            let degrees = spec.require_number("degrees")?;
            (Box::new(Cap::from_degrees(degrees).map_err(wrong)?), vec!["degrees"])
        }
        "double-cap" => {
            let degrees = spec.require_number("degrees")?;
            (Box::new(DoubleCap::from_degrees(degrees).map_err(wrong)?), vec!["degrees"])
        }
        "half-space" => {
            let height = spec.take_number("height")?.unwrap_or(0.0);
            (Box::new(Cap::half_space(height).map_err(wrong)?), vec!["height"])
        }
        "vmf" => {
            let kappa = spec.require_number("kappa")?;
            (Box::new(VonMisesFisher::new(kappa).map_err(wrong)?), vec!["kappa"])
        }
        "phong" => {
            let exponent = spec.require_number("n")?;
            (Box::new(PhongLobe::new(exponent).map_err(wrong)?), vec!["n"])
        }
        "cosine" => (Box::new(ClampedCosine), vec![]),
        "abs-cosine" => (Box::new(AbsCosine), vec![]),
        "env" => {
            let file = file(&mut spec, text)?;
            let mut environment = Environment::take(&mut spec, &file)?;
            remarks.append(&mut environment.remarks);
            (environment.integrand()?, [&["file"], &environment::KEYS[..]].concat())
        }
        "map" => {
            let file = file(&mut spec, text)?;
            let map = healpix_map::take(&mut spec, &file, remarks)?;
            (Box::new(map), [&["file"], &healpix_map::KEYS[..]].concat())
        }
        name => return Err(unknown_name("integrand", name, &NAMES)),
    };
    spec.finish(&keys)?;
    Ok(function)
}

fn file(spec: &mut Spec, text: &str) -> Result<PathBuf, CliError> {
    let name = spec.name.clone();
    spec.take_path("")
        .or_else(|| spec.take_path("file"))
        .ok_or_else(|| CliError::Usage(format!("{text}: the file is missing: {name}:FILE")))
}
