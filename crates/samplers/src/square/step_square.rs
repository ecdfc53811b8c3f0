use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, Rate, SpectralControl, Square, SquareSampler,
    SquareSpectralControl,
};

/// Parameters of the pattern [`SquareSpectralControl::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSquareParameters {
    /// No power at any frequency with |k| up to alpha sqrt(N); if not given, the default of
    /// [`SquareSpectralControl::step`].
    pub alpha: Option<f64>,
    /// The power of white noise from there to flat sqrt(N); if not given, the default of
    /// [`SquareSpectralControl::step`].
    pub flat: Option<f64>,
    /// The minimum toroidal distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl StepSquareParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { alpha: None, flat: None, core: SpectralControl::STEP_CORE };
}

impl Default for StepSquareParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for StepSquareParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let (range, summary) =
            (SquareSpectralControl::ALPHA_RANGE, "no power at |k| up to alpha sqrt(N)");
        d.optional_number("alpha", range, summary, "by N", &mut self.alpha);
        let summary = "white noise's power from there to |k| = flat sqrt(N)";
        d.optional_number("flat", SpectralControl::FLAT_RANGE, summary, "by N", &mut self.flat);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition<Square> for StepSquareParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "0 for |k| <= alpha sqrt(N)",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "this project; Graef and Potts 2011",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        let step = SquareSpectralControl::step(n_points, self.alpha, self.flat)?;
        Ok(Box::new(step.with_core(self.core)?))
    }
}
