//! The profiles of the command line.

use sphvar_bounds::{Profile, ProfileShape};

use crate::error::CliError;
use crate::spec::{Spec, unknown_name};

/// A parsed profile, with a record of the parameters that were given.
pub(crate) struct ParsedProfile {
    pub(crate) profile: Profile,
    pub(crate) has_alpha: bool,
    pub(crate) has_gamma: bool,
}

/// Returns the profile of a specification such as `poly:b=2,alpha=0.5`; alpha and gamma are 1 if
/// omitted.
pub(crate) fn parse_profile(text: &str) -> Result<ParsedProfile, CliError> {
    let mut spec = Spec::parse(text)?;
    let shape = match spec.name.as_str() {
        "constant" => ProfileShape::Constant,
        "step" => ProfileShape::Step,
        "linear" => ProfileShape::Polynomial { exponent: 1.0 },
        "quadratic" => ProfileShape::Polynomial { exponent: 2.0 },
        "poly" => ProfileShape::Polynomial { exponent: spec.require_number("b")? },
        name => {
            let known = ["constant", "step", "linear", "quadratic", "poly"];
            return Err(unknown_name("profile", name, &known));
        }
    };
    let alpha = spec.take_number("alpha")?;
    let gamma = spec.take_number("gamma")?;
    let offset = spec.take_number("offset")?.unwrap_or(0.0);
    spec.finish(&["alpha", "gamma", "offset", "b (poly)"])?;
    let wrong = |e: sphvar_bounds::Error| CliError::Usage(format!("{text}: {e}"));
    let profile = Profile::new(shape, alpha.unwrap_or(1.0), gamma.unwrap_or(1.0))
        .and_then(|p| p.with_offset(offset))
        .map_err(wrong)?;
    // A constant does not level off.
    let has_alpha = alpha.is_some() || shape == ProfileShape::Constant;
    Ok(ParsedProfile { profile, has_alpha, has_gamma: gamma.is_some() })
}
