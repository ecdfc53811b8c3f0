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

impl Parametric for ProfileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let table = match &self.profile {
            PowerProfile::Table { name, .. } => Some(PathBuf::from(&**name)),
            PowerProfile::Polynomial { .. } | PowerProfile::Colour(_) => None,
        };
        let mut file = table.clone();
        d.file("file", "table of l,power instead of colour or b to `to`", "none", &mut file);
        if let Some(file) = file.filter(|file| Some(file) != table.as_ref()) {
            // The powers are read once all parameters are known.
            let name = file.to_string_lossy().into();
            self.profile = PowerProfile::Table { name, power: [].into() };
        }
        if !matches!(self.profile, PowerProfile::Table { .. }) {
            let mut colour = match self.profile {
                PowerProfile::Colour(colour) => Some(colour),
                _ => None,
            };
            d.optional_choice(
                "colour",
                "colour of noise instead of b to `to`",
                "none",
                &mut colour,
            );
            if let Some(colour) = colour {
                self.profile = PowerProfile::Colour(colour);
            }
        }
        if let PowerProfile::Polynomial { exponent, alpha, gamma, offset, to } = &mut self.profile {
            d.number("b", Range::AT_LEAST_0, "exponent of l/sqrt(N)", exponent);
            d.number("alpha", Range::POSITIVE, "where the profile levels off, l/sqrt(N)", alpha);
            d.number("gamma", Range::AT_LEAST_0, "level above the offset", gamma);
            d.number("offset", Range::AT_LEAST_0, "power at degree 0", offset);
            d.number("to", PowerProfile::TO_RANGE, "where the target ends, l/sqrt(N)", to);
        }
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
        if let PowerProfile::Table { name, power } = &mut self.profile {
            *power = files.powers(Path::new(&**name))?.into();
        }
        Ok(())
    }
}
