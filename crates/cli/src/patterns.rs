//! Samplers as they are named on the command line.

use std::path::Path;

use sphvar_samplers::{
    DiskMode, Domain, Error, MassPoints, Pattern, Placement, PowerProfile, Sampler,
};

use crate::error::CliError;
use crate::files::read_spectrum;
use crate::memory::check_points;
use crate::spec::{Spec, unknown_name};

/// The name that stands for every pattern, wherever several make sense.
const ALL: &str = "all";

/// The patterns of a list such as `jittered,white-noise`, or `all`.
pub(crate) fn parse_patterns(text: &str) -> Result<Vec<Pattern>, CliError> {
    let mut patterns = Vec::new();
    for spec in Spec::parse_list(text)? {
        if spec.text == ALL {
            patterns.extend(Pattern::ALL);
        } else {
            patterns.push(pattern(spec)?);
        }
    }
    Ok(patterns)
}

/// The pattern of one name.
pub(crate) fn parse_pattern(text: &str) -> Result<Pattern, CliError> {
    pattern(Spec::parse(text)?)
}

fn pattern(mut spec: Spec) -> Result<Pattern, CliError> {
    let known: Vec<&str> = Pattern::ALL.iter().map(Pattern::name).collect();
    let mut pattern = Pattern::from_name(&spec.name)
        .ok_or_else(|| unknown_name("sampler", &spec.name, &known))?;
    let keys = take_parameters(&mut pattern, &mut spec)?;
    spec.finish(keys)?;
    Ok(pattern)
}

/// The keys of a pattern's parameters, with the values of those that are names.
pub(crate) fn parameter_keys(pattern: &Pattern) -> Result<&'static [&'static str], CliError> {
    take_parameters(&mut pattern.clone(), &mut Spec::parse(pattern.name())?)
}

/// Sets what the specification gives, and returns the keys that there are.
fn take_parameters(
    pattern: &mut Pattern,
    spec: &mut Spec,
) -> Result<&'static [&'static str], CliError> {
    Ok(match pattern {
        Pattern::PoissonDisk { mode, radius } => {
            let modes = [DiskMode::Exact, DiskMode::Saturated].map(|m| (m.name(), m));
            spec.replace_choice("mode", &modes, mode)?;
            *radius = spec.take_number("radius")?;
            &["radius", "mode (exact, saturated)"]
        }
        Pattern::Ccvt { capacity, mass } => {
            spec.replace_number("capacity", capacity)?;
            spec.replace_choice("mass", &MassPoints::ALL.map(|m| (m.name(), m)), mass)?;
            &["capacity", "mass (white, fibonacci, healpix)"]
        }
        Pattern::Step { alpha, flat, core } => {
            *alpha = spec.take_number("alpha")?;
            *flat = spec.take_number("flat")?;
            spec.replace_number("core", core)?;
            &["alpha", "flat", "core"]
        }
        Pattern::Blue { alpha, core } => {
            *alpha = spec.take_number("alpha")?;
            spec.replace_number("core", core)?;
            &["alpha", "core"]
        }
        Pattern::Profile { profile, core } => {
            spec.replace_number("core", core)?;
            if let Some(path) = spec.take("") {
                *profile = read_profile(&path)?;
                return Ok(&["core"]);
            }
            if let PowerProfile::Polynomial { exponent, alpha, gamma, offset, to } = profile {
                spec.replace_number("b", exponent)?;
                spec.replace_number("alpha", alpha)?;
                spec.replace_number("gamma", gamma)?;
                spec.replace_number("offset", offset)?;
                spec.replace_number("to", to)?;
            }
            &["a file of l,power first of all", "b", "alpha", "gamma", "offset", "to", "core"]
        }
        Pattern::EqualArea { placement } => {
            let placements = [Placement::Jittered, Placement::Centred].map(|p| (p.name(), p));
            spec.replace_choice("placement", &placements, placement)?;
            &["placement (jittered, centred)"]
        }
        Pattern::BestCandidate { factor } => {
            spec.replace_number("factor", factor)?;
            &["factor"]
        }
        Pattern::Lloyd { iterations } => {
            spec.replace_number("iterations", iterations)?;
            &["iterations"]
        }
        Pattern::Riesz { s, iterations } => {
            spec.replace_number("s", s)?;
            spec.replace_number("iterations", iterations)?;
            &["s", "iterations"]
        }
        _ => &[],
    })
}

/// The powers of a file of degrees and powers, which begins at degree 0 or 1 and leaves none out.
fn read_profile(path: &str) -> Result<PowerProfile, CliError> {
    let rows = read_spectrum(Path::new(path))?;
    let first = rows.first().map_or(0, |row| row.l);
    // Degree 0 does not count.
    let powers = (0..first).map(|_| 0.0).chain(rows.iter().map(|row| row.power));
    Ok(PowerProfile::Table { name: path.into(), power: powers.collect() })
}

/// The sampler of `n` points, or of the nearest number that the pattern has if `nearest`.
pub(crate) fn build(
    pattern: &Pattern,
    n: usize,
    domain: Domain,
    nearest: bool,
) -> Result<Box<dyn Sampler>, CliError> {
    let n = if nearest && n > 0 { pattern.nearest_count(n, domain) } else { n };
    let sampler = pattern.build(n, domain).map_err(|error| match error {
        Error::IllegalCount { .. } => CliError::Usage(format!("{error} (--nearest takes it)")),
        _ => CliError::usage(error),
    })?;
    check_points(sampler.n_points())?;
    Ok(sampler)
}
