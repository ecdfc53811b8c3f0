//! The samplers of the command line.

use std::path::Path;

use sphvar_grammar::ResolveError;
use sphvar_samplers::{Domain, Error, Pattern, ProfileResolver, Sampler};

use crate::error::CliError;
use crate::files::read_spectrum;
use crate::memory::check_points;
use crate::spec::Spec;

/// The name of all patterns together, for subcommands that accept several.
const ALL: &str = "all";

/// Returns the patterns of a list such as `jittered,white-noise`, or of `all`.
pub(crate) fn parse_patterns(text: &str) -> Result<Vec<Pattern>, CliError> {
    let mut patterns = Vec::new();
    for spec in Spec::parse_list(text)? {
        if spec.text == ALL {
            patterns.extend(Pattern::ALL);
        } else {
            patterns.push(parse_pattern(&spec.text)?);
        }
    }
    Ok(patterns)
}

/// Returns the pattern of one name.
pub(crate) fn parse_pattern(text: &str) -> Result<Pattern, CliError> {
    Pattern::parse(text, &ProfileFiles).map_err(|error| match error {
        Error::File(source) => CliError::of_resolver(&source),
        other => CliError::usage(other),
    })
}

/// Reads the files of `profile:FILE` as the command reads spectra.
struct ProfileFiles;

impl ProfileResolver for ProfileFiles {
    /// Returns the powers of a file of degrees and powers, which starts at degree 0 or 1 without
    /// gaps.
    fn powers(&self, file: &Path) -> Result<Vec<f64>, ResolveError> {
        let rows = read_spectrum(file).map_err(|error| ResolveError::new(CliError::from(error)))?;
        let first = rows.first().map_or(0, |row| row.l);
        // Degree 0 is ignored.
        Ok((0..first).map(|_| 0.0).chain(rows.iter().map(|row| row.power)).collect())
    }
}

/// Returns the sampler of `n` points or, if `nearest`, of the nearest valid count.
pub(crate) fn build(
    pattern: &Pattern,
    n: usize,
    domain: Domain,
    nearest: bool,
) -> Result<Box<dyn Sampler>, CliError> {
    let n = if nearest && n > 0 { pattern.nearest_count(n, domain) } else { n };
    let sampler = pattern.build(n, domain).map_err(|error| match error {
        Error::InvalidCount { .. } => CliError::Usage(format!("{error} (use --nearest)")),
        _ => CliError::usage(error),
    })?;
    check_points(sampler.n_points())?;
    Ok(sampler)
}
