//! Samplers of directions: uniform patterns, and patterns of the square that are mapped to a
//! density.

use std::fmt;

use sphvar_samplers::{Pattern, SquarePattern, SquareSampler};
use sphvar_variance::{AdaptedPattern, Error, WarpedPattern};

use super::{
    ALL, PatternFiles, PatternKind, SamplerName, error_of_pattern, parse_pattern,
    with_distinct_labels,
};
use crate::error::CliError;
use crate::memory::check_points;
use crate::session::Session;
use crate::spec::Spec;

/// A sampler of directions by which integrals are estimated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum DirectionSampler {
    /// A pattern of uniform directions, randomly rotated.
    Uniform(Pattern),
    /// A pattern of the square mapped to one or several densities.
    Warped(WarpedPattern),
    /// Tessellations for a density, whose variance is measured only.
    Adapted(AdaptedPattern),
}

impl DirectionSampler {
    /// Returns its names in results.
    pub(crate) fn name(&self) -> SamplerName {
        match self {
            Self::Uniform(pattern) => SamplerName::of(pattern),
            Self::Warped(warped) => SamplerName {
                text: warped.to_string(),
                label: warped.label(),
                is_file: warped.pattern.is_file(),
            },
            Self::Adapted(adapted) => {
                let text = adapted.to_string();
                SamplerName { label: text.clone(), text, is_file: false }
            }
        }
    }

    fn use_long_label(&mut self) {
        match self {
            Self::Uniform(pattern) => pattern.use_long_label(),
            Self::Warped(warped) => {
                warped.pattern.use_long_label();
                warped.has_long_label = true;
            }
            Self::Adapted(_) => {}
        }
    }
}

impl fmt::Display for DirectionSampler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uniform(pattern) => pattern.fmt(f),
            Self::Warped(warped) => warped.fmt(f),
            Self::Adapted(adapted) => adapted.fmt(f),
        }
    }
}

/// Returns the samplers of a list such as `jittered,sobol:warp=cosine`; `all` are the patterns of
/// the sphere. Reports remarks on files of points.
pub(crate) fn parse_samplers(
    text: &str,
    session: &Session,
) -> Result<Vec<DirectionSampler>, CliError> {
    let mut samplers = Vec::new();
    for spec in Spec::parse_list(text)? {
        if spec.text == ALL {
            samplers.extend(Pattern::all().into_iter().map(DirectionSampler::Uniform));
        } else {
            samplers.push(parse_sampler(&spec.text, session)?);
        }
    }
    with_distinct_labels(&mut samplers, DirectionSampler::name, DirectionSampler::use_long_label);
    Ok(samplers)
}

/// Returns the sampler of one name. Reports remarks on files of points.
pub(crate) fn parse_sampler(text: &str, session: &Session) -> Result<DirectionSampler, CliError> {
    if WarpedPattern::is_warped(text) {
        return parse_warped(text, session).map(DirectionSampler::Warped);
    }
    if AdaptedPattern::is_adapted(text) {
        let adapted = text.parse::<AdaptedPattern>();
        return adapted
            .map(DirectionSampler::Adapted)
            .map_err(|error| CliError::Usage(with_text(text, &error)));
    }
    parse_pattern(text, session).map(DirectionSampler::Uniform)
}

/// Why tessellations for a density have no prediction.
pub(crate) const UNPREDICTED: &str = "its sites are neither homogeneous nor the image of a pattern of the square, so no spectrum predicts its variance, and its estimates are biased";

/// Returns an error after the text that it is about, unless it contains that.
fn with_text(text: &str, error: &Error) -> String {
    let message = error.to_string();
    if message.contains(text) { message } else { format!("{text}: {message}") }
}

/// Rejects the names of patterns of the sphere, which cannot be mapped to a density.
pub(crate) fn check_square_pattern(text: &str) -> Result<(), CliError> {
    let name = text.split(':').next().unwrap_or_default();
    if Pattern::is_name(name) && !SquarePattern::is_name(name) {
        let known: Vec<&str> = SquarePattern::known().map(|pattern| pattern.name()).collect();
        return Err(CliError::Usage(format!(
            "{name} is a pattern of the sphere; warp= maps those of the unit square: {}",
            known.join(", ")
        )));
    }
    Ok(())
}

fn parse_warped(text: &str, session: &Session) -> Result<WarpedPattern, CliError> {
    check_square_pattern(text)?;
    WarpedPattern::parse(text, &PatternFiles { session }).map_err(|error| match error {
        Error::Spectrum(sphvar_spectrum::Error::Sampler(error)) => {
            error_of_pattern::<SquarePattern>(text, error)
        }
        error => CliError::Usage(with_text(text, &error)),
    })
}

/// Returns the samplers of the strategies of a warped pattern with `n` points or, if `nearest`, with
/// the nearest valid count, and that number; for a single file, its own.
pub(crate) fn build_warped(
    pattern: &WarpedPattern,
    n: usize,
    nearest: bool,
) -> Result<(usize, Vec<Box<dyn SquareSampler>>), CliError> {
    let nearest = nearest || pattern.own_count().is_some();
    let n = if nearest && n > 0 { pattern.nearest_count(n) } else { n };
    check_points(n)?;
    let samplers = pattern.samplers(n).map_err(|error| match error {
        Error::Total { .. }
        | Error::Spectrum(sphvar_spectrum::Error::Sampler(
            sphvar_samplers::Error::InvalidCount { .. },
        )) => CliError::Usage(format!("{error} (use --nearest)")),
        error => CliError::usage(error),
    })?;
    Ok((n, samplers))
}
