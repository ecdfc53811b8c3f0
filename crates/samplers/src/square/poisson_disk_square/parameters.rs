use sphvar_grammar::{Declaration, Parametric, Range};

use super::PoissonDiskSquare;
use crate::definition::Definition;
use crate::{CostOrder, DiskMode, Error, PatternFacts, Rate, Square, SquareSampler};

/// Parameters of the pattern [`PoissonDiskSquare`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoissonDiskSquareParameters {
    /// The criterion by which a set is complete.
    pub mode: DiskMode,
    /// The minimum distance times sqrt(N), or [`PoissonDiskSquare::default_radius`].
    pub radius: Option<f64>,
    /// Whether distances are toroidal.
    pub is_wrapped: bool,
}

impl PoissonDiskSquareParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { mode: DiskMode::Exact, radius: None, is_wrapped: true };
}

impl Default for PoissonDiskSquareParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for PoissonDiskSquareParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice(
            "mode",
            "exactly N points, or the number at which the set is saturated",
            &mut self.mode,
        );
        let summary = "minimum distance times sqrt(N)";
        d.optional_number("radius", Range::POSITIVE, summary, "by N", &mut self.radius);
        d.choice("wrapped", "whether distances are toroidal", &mut self.is_wrapped);
    }
}

impl Definition<Square> for PoissonDiskSquareParameters {
    fn facts(&self) -> PatternFacts {
        let low_degrees = match (self.mode, self.is_wrapped) {
            (DiskMode::Exact, true) => "0.0596",
            (DiskMode::Saturated, true) => "0.0578",
            (DiskMode::Exact, false) => "0.06, 0.3 on the axes",
            (DiskMode::Saturated, false) => "0.06, 0.4 on the axes",
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees,
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: false,
            source: "Cook 1986; Gamito and Maddock 2009",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        let Self { mode, radius, is_wrapped } = *self;
        Ok(Box::new(PoissonDiskSquare::new(n_points, mode, is_wrapped, radius)?))
    }
}
