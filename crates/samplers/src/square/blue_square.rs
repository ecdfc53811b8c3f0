use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, Rate, SpectralControl, Square, SquareSampler,
    SquareSpectralControl,
};

/// Parameters of the pattern [`SquareSpectralControl::blue`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlueSquareParameters {
    /// No power at any frequency with |k| up to alpha sqrt(N); if not given, the default of
    /// [`SquareSpectralControl::blue`].
    pub alpha: Option<f64>,
    /// The minimum toroidal distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl BlueSquareParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { alpha: None, core: SpectralControl::BLUE_CORE };
}

impl Default for BlueSquareParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for BlueSquareParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let (range, summary) =
            (SquareSpectralControl::ALPHA_RANGE, "no power at |k| up to alpha sqrt(N)");
        d.optional_number("alpha", range, summary, "by N", &mut self.alpha);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition<Square> for BlueSquareParameters {
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
        let blue = SquareSpectralControl::blue(n_points, self.alpha)?;
        Ok(Box::new(blue.with_core(self.core)?))
    }
}
