use rand::Rng;
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{
    CostOrder, Error, Lattice, PatternFacts, PointSet, Rate, Square, SquareDistribution,
    SquareSampler, ValidCounts,
};

/// The centres of the rectangles of a grid on the square: point (i, j) is
/// `((i + 1/2)/rows, (j + 1/2)/columns)`.
#[derive(Clone, Copy, Debug)]
pub struct RegularSquare {
    lattice: Lattice,
}

impl RegularSquare {
    /// Returns the grid of `rows` values of u and `columns` values of v.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless the product is from 1 to `u32::MAX`.
    pub fn new(rows: usize, columns: usize) -> Result<Self, Error> {
        Ok(Self { lattice: Lattice::grid(rows, columns)? })
    }
}

impl SquareSampler for RegularSquare {
    fn n_points(&self) -> usize {
        self.lattice.n_points()
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Lattice(self.lattice)
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        let [rows, columns, _] = self.lattice.normal_form();
        let centre = |index: usize, n: usize| (index as f64 + 0.5) / n as f64;
        let point = |k: usize| [centre(k / columns, rows), centre(k % columns, columns)];
        set.start().extend((0..self.n_points()).map(point));
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<Square> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "0",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "definition",
        }
    }

    fn valid_counts(&self, _: Square) -> ValidCounts {
        ValidCounts::Squares { unit: 1, root: "k" }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(RegularSquare::new(n_points.isqrt(), n_points.isqrt())?))
    }
}
