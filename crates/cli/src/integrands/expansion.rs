//! Integrands with energies or coefficients from files.

use sphvar_integrands::{AlmParameters, EnergiesParameters, EnergyEstimates, Expansion};
use sphvar_spectrum::Method;

use crate::error::CliError;
use crate::memory::{check_degree, check_memory};
use crate::session::Session;

/// Reads the energies of a file.
pub(super) fn read_energies(
    wanted: &EnergiesParameters,
    session: &Session,
    remarks: &mut Vec<String>,
) -> Result<EnergyEstimates, CliError> {
    let file = session.read_energies(&wanted.file, wanted.quantity)?;
    let name = wanted.file.display().to_string();
    let count = file.energies.per_degree.len();
    check_degree(&name, count - 1)?;
    if !file.negative.is_empty() {
        remarks.push(format!(
            "{name}: {} of {count} energies are negative, as noise makes estimates of 0; the function has none in \
             these degrees",
            file.negative.len()
        ));
    }
    Ok(file.energies)
}

/// Reads the coefficients of a file.
pub(super) fn read_coefficients(
    wanted: &AlmParameters,
    session: &Session,
    remarks: &mut Vec<String>,
) -> Result<Expansion, CliError> {
    let hdu = wanted.hdu.as_deref();
    let (path, coefficients) = session.read_coefficients(&wanted.file, hdu, remarks)?;
    Expansion::new(coefficients).map_err(|e| CliError::File(format!("{}: {e}", path.display())))
}

/// Rejects a degree whose coefficients and transforms do not fit in memory.
pub(super) fn check_values(lmax: usize) -> Result<(), String> {
    // The coefficients are in the function, and once more in a transform to its values.
    let bytes = Method::Fast.bytes(0, lmax, 1) + Method::Exact.bytes(0, lmax, 1);
    check_memory(&format!("a function of degree {lmax}"), bytes).map_err(|e| e.to_string())
}
