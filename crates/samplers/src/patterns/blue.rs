use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, Rate, Sampler, SpectralControl};

/// Parameters of the pattern [`SpectralControl::blue`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlueParameters {
    /// No power at any degree up to alpha sqrt(N); if not given, the default of
    /// [`SpectralControl::blue`].
    pub alpha: Option<f64>,
    /// The minimum distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl BlueParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { alpha: None, core: SpectralControl::BLUE_CORE };
}

impl Default for BlueParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for BlueParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "no power at degrees up to alpha sqrt(N)";
        d.optional_number("alpha", SpectralControl::ALPHA_RANGE, summary, "by N", &mut self.alpha);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition for BlueParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "0 for l <= alpha sqrt(N)",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "this project; Graef and Potts 2011",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let blue = SpectralControl::blue(n_points, domain, self.alpha)?;
        Ok(Box::new(blue.with_core(self.core)?))
    }
}
