//! Samplers as they are named on the command line.

use sphvar_samplers::{Domain, Error, Pattern, Sampler};

use crate::error::CliError;
use crate::spec::{Spec, unknown_name};

/// The patterns of a list such as `jittered,white-noise`.
pub(crate) fn parse_patterns(text: &str) -> Result<Vec<Pattern>, CliError> {
    Spec::parse_list(text)?.into_iter().map(pattern).collect()
}

/// The pattern of one name.
pub(crate) fn parse_pattern(text: &str) -> Result<Pattern, CliError> {
    pattern(Spec::parse(text)?)
}

fn pattern(spec: Spec) -> Result<Pattern, CliError> {
    let known: Vec<&str> = Pattern::ALL.iter().map(|p| p.name()).collect();
    let pattern = Pattern::from_name(&spec.name)
        .ok_or_else(|| unknown_name("sampler", &spec.name, &known))?;
    spec.finish(&[])?;
    Ok(pattern)
}

/// The sampler of `n` points, or of the nearest number that the pattern has if `nearest`.
pub(crate) fn build(
    pattern: Pattern,
    n: usize,
    domain: Domain,
    nearest: bool,
) -> Result<Box<dyn Sampler>, CliError> {
    let n = if nearest && n > 0 { pattern.nearest_count(n, domain) } else { n };
    pattern.build(n, domain).map_err(|error| match error {
        Error::IllegalCount { .. } => CliError::Usage(format!("{error} (--nearest takes it)")),
        _ => CliError::usage(error),
    })
}
