//! The option `--coefficient`.

use std::path::{Path, PathBuf};

use sphvar_samplers::Domain;

use crate::error::CliError;

/// The coefficient whose samples are requested.
pub(super) struct Coefficient {
    pub(super) l: usize,
    pub(super) m: usize,
    pub(super) path: PathBuf,
}

/// Parses the words of `--coefficient` for degrees up to `lmax`.
pub(super) fn parse_coefficient(
    words: &[String],
    lmax: usize,
    domain: Domain,
) -> Result<Coefficient, CliError> {
    let number = |word: &String| {
        word.parse::<usize>().map_err(|_| {
            CliError::Usage(format!("--coefficient L M FILE: \"{word}\" is not a number"))
        })
    };
    let [l, m, path] = words else {
        return Err(CliError::Usage("--coefficient takes L M FILE".to_owned()));
    };
    let (l, m) = (number(l)?, number(m)?);
    if m > l || l > lmax {
        return Err(CliError::Usage(format!(
            "--coefficient must satisfy 0 <= M <= L <= lmax, got L = {l}, M = {m}, lmax = {lmax}"
        )));
    }
    if !domain.has_degree(l) {
        return Err(CliError::Usage(format!(
            "--coefficient: the {domain} has even degrees only, got L = {l}"
        )));
    }
    Ok(Coefficient { l, m, path: Path::new(path).to_path_buf() })
}
