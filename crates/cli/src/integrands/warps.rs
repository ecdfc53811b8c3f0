//! The densities of warps, with the files that they name.

use sphvar_integrands::{Error, Strategy, WarpExpression};
use sphvar_samplers::Domain;

use super::IntegrandFiles;
use crate::error::CliError;
use crate::session::Session;

/// Returns the densities of warps over a domain. Reads every picture once and reports remarks on the
/// files.
pub(crate) fn strategies_of(
    warps: &[&WarpExpression],
    domain: Domain,
    session: &Session,
) -> Result<Vec<Vec<Strategy>>, CliError> {
    let files = IntegrandFiles::new(session);
    let strategies = |warp: &&WarpExpression| {
        warp.strategies(domain, &files).map_err(|error| match error {
            Error::File(source) => CliError::of_resolver(&source),
            other => CliError::Usage(format!("warp={warp}: {other}")),
        })
    };
    let all = warps.iter().map(strategies).collect();
    files.report();
    all
}
