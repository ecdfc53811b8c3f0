//! Fits to values in files.

use std::ops::ControlFlow;

use sphvar_integrands::{FittedFunction, ValuesParameters};
use sphvar_samplers::Domain;
use sphvar_spectrum::FitError;

use crate::error::CliError;
use crate::files::{OptionSpelling, ReadOptions};
use crate::memory::check_degree;
use crate::report::number::value;
use crate::session::Session;
use crate::values::Values;

/// Returns the fit to the values of a file.
pub(super) fn fit(
    wanted: &ValuesParameters,
    session: &Session,
    remarks: &mut Vec<String>,
) -> Result<FittedFunction, CliError> {
    let name = wanted.file.display().to_string();
    let wrong =
        |key: &str, reason: String| CliError::Usage(format!("values:{name}: {key}: {reason}"));
    check_degree(&format!("lmax of values:{name}"), wanted.lmax)?;
    let columns = wanted.columns.as_deref().map(str::parse).transpose();
    let hdu = wanted.hdu.as_deref().map(str::parse).transpose();
    let options = ReadOptions {
        columns: columns.map_err(|reason| wrong("columns", reason))?,
        hdu: hdu.map_err(|reason| wrong("hdu", reason))?.unwrap_or_default(),
        skip_invalid: wanted.skip_invalid,
        normalize: wanted.normalize,
        spelling: OptionSpelling::Keys,
        values: true,
        ..ReadOptions::default()
    };
    let domain = if wanted.hemisphere { Domain::Hemisphere } else { Domain::Sphere };
    let values = Values::read(std::slice::from_ref(&wanted.file), &options, domain, session)?;
    remarks.extend(values.remarks.iter().cloned());
    let error = |error: FitError| match error {
        FitError::TooFewPoints { .. } => CliError::Usage(format!("{name}: {error}")),
        _ => CliError::Failed(format!("{name}: {error}")),
    };
    let problem = values.problem(domain, wanted.ridge).map_err(error)?;
    let fit = problem.solve(wanted.lmax, &mut || ControlFlow::Continue(())).map_err(error)?;
    remarks.push(format!(
        "{name}: the integrand is the fit of degree {}, and exact integrals are those of the fit; residuals: {} (root \
         mean square)",
        wanted.lmax,
        value(fit.residual_rms)
    ));
    FittedFunction::new(&fit).map_err(|error| CliError::Failed(format!("{name}: {error}")))
}
