use std::path::{Path, PathBuf};

use sphvar_grammar::{Declaration, Parametric, Range};

use crate::definition::{Definition, FileResolver};
use crate::{CostOrder, Domain, Error, PatternFacts, PowerProfile, Rate, Sampler, SpectralControl};

/// Parameters of the pattern [`SpectralControl::profile`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileParameters {
    /// The power at each degree.
    pub profile: PowerProfile,
    /// The minimum distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl ProfileParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { profile: PowerProfile::QUADRATIC, core: 0.0 };
}

impl Default for ProfileParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The meanings of the parameters of a profile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProfileWords {
    pub(crate) table: &'static str,
    pub(crate) exponent: &'static str,
    pub(crate) alpha: &'static str,
    pub(crate) offset: &'static str,
    pub(crate) to: &'static str,
}

const DEGREES: ProfileWords = ProfileWords {
    table: "table of l,power instead of colour or b to `to`",
    exponent: "exponent of l/sqrt(N)",
    alpha: "where the profile levels off, l/sqrt(N)",
    offset: "power at degree 0",
    to: "where the target ends, l/sqrt(N)",
};

/// Declares the parameters of a profile.
pub(crate) fn declare_profile(
    profile: &mut PowerProfile,
    words: ProfileWords,
    d: &mut Declaration<'_>,
) {
    let table = match &*profile {
        PowerProfile::Table { name, .. } => Some(PathBuf::from(&**name)),
        PowerProfile::Polynomial { .. } | PowerProfile::Colour(_) => None,
    };
    let mut file = table.clone();
    d.file("file", words.table, "none", &mut file);
    if let Some(file) = file.filter(|file| Some(file) != table.as_ref()) {
        // The powers are read once all parameters are known.
        let name = file.to_string_lossy().into();
        *profile = PowerProfile::Table { name, power: [].into() };
    }
    if !matches!(profile, PowerProfile::Table { .. }) {
        let mut colour = match profile {
            PowerProfile::Colour(colour) => Some(*colour),
            _ => None,
        };
        d.optional_choice("colour", "colour of noise instead of b to `to`", "none", &mut colour);
        if let Some(colour) = colour {
            *profile = PowerProfile::Colour(colour);
        }
    }
    if let PowerProfile::Polynomial { exponent, alpha, gamma, offset, to } = profile {
        d.number("b", Range::AT_LEAST_0, words.exponent, exponent);
        d.number("alpha", Range::POSITIVE, words.alpha, alpha);
        d.number("gamma", Range::AT_LEAST_0, "level above the offset", gamma);
        d.number("offset", Range::AT_LEAST_0, words.offset, offset);
        d.number("to", PowerProfile::TO_RANGE, words.to, to);
    }
}

/// Reads the table that a profile names.
pub(crate) fn resolve_profile(
    profile: &mut PowerProfile,
    files: &dyn FileResolver,
) -> Result<(), Error> {
    if let PowerProfile::Table { name, power } = profile {
        *power = files.powers(Path::new(&**name))?.into();
    }
    Ok(())
}

impl Parametric for ProfileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        declare_profile(&mut self.profile, DEGREES, d);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition for ProfileParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "as requested",
            smooth_rate: Rate::AsRequested,
            jump_rate: Rate::AsRequested,
            is_extensible: false,
            source: "this project",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let profile = SpectralControl::profile(n_points, domain, &self.profile)?;
        Ok(Box::new(profile.with_core(self.core)?))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        resolve_profile(&mut self.profile, files)
    }
}
