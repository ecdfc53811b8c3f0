use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, Rate, Sampler, SpectralControl};

/// Parameters of the pattern [`SpectralControl::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepParameters {
    /// No power at any degree up to alpha sqrt(N); if not given, the default of
    /// [`SpectralControl::step`].
    pub alpha: Option<f64>,
    /// The power of white noise from there to flat sqrt(N); if not given, the default of
    /// [`SpectralControl::step`].
    pub flat: Option<f64>,
    /// The minimum distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl StepParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { alpha: None, flat: None, core: SpectralControl::STEP_CORE };
}

impl Default for StepParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for StepParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "no power at degrees up to alpha sqrt(N)";
        d.optional_number("alpha", SpectralControl::ALPHA_RANGE, summary, "by N", &mut self.alpha);
        let summary = "white noise's power from there to flat sqrt(N)";
        d.optional_number("flat", SpectralControl::FLAT_RANGE, summary, "by N", &mut self.flat);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition for StepParameters {
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
        let step = SpectralControl::step(n_points, domain, self.alpha, self.flat)?;
        Ok(Box::new(step.with_core(self.core)?))
    }
}
