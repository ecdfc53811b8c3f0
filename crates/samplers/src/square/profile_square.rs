use sphvar_grammar::{Declaration, Parametric};

use crate::definition::{Definition, FileResolver};
use crate::patterns::profile::{ProfileWords, declare_profile, resolve_profile};
use crate::{
    CostOrder, Error, PatternFacts, PowerProfile, Rate, SinglePeak, SpectralControl, Square,
    SquareSampler, SquareSpectralControl,
};

/// Parameters of the pattern [`SquareSpectralControl::profile`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileSquareParameters {
    /// The power in each ring of frequencies.
    pub profile: PowerProfile,
    /// The minimum toroidal distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl ProfileSquareParameters {
    /// The default parameters: the profile `min(1, (omega/0.564)^2)` up to omega = 1.128, which has
    /// as many frequencies as [`PowerProfile::QUADRATIC`] has harmonics.
    pub const DEFAULT: Self = Self {
        profile: PowerProfile::Polynomial {
            exponent: 2.0,
            alpha: 0.564,
            gamma: 1.0,
            offset: 0.0,
            to: 1.128,
        },
        core: 0.0,
    };
}

impl Default for ProfileSquareParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

const FREQUENCIES: ProfileWords = ProfileWords {
    table: "table of |k|,power instead of colour, edge or b to `to`",
    edge: "edge of single-peak blue noise instead of b to offset, |k|/sqrt(N)",
    // The frequencies of the sphere's divided by sqrt(pi).
    single_peak: SinglePeak { edge: 0.677, peak: None, width: 0.0564, to: 1.128 },
    exponent: "exponent of |k|/sqrt(N)",
    alpha: "where the profile levels off, |k|/sqrt(N)",
    offset: "power at frequency 0",
    to: "where the target ends, |k|/sqrt(N)",
};

impl Parametric for ProfileSquareParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        declare_profile(&mut self.profile, FREQUENCIES, d);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition<Square> for ProfileSquareParameters {
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

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        let profile = SquareSpectralControl::profile(n_points, &self.profile)?;
        Ok(Box::new(profile.with_core(self.core)?))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        resolve_profile(&mut self.profile, files)
    }
}
