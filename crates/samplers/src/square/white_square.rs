use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Rate, Square, SquareDistribution, SquareSampler,
    count,
};

/// Independent uniform points of the square.
#[derive(Clone, Copy, Debug)]
pub struct WhiteSquare {
    n: u32,
}

impl WhiteSquare {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for WhiteSquare {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Independent
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        set.start().extend((0..self.n).map(|_| rng.random::<[f64; 2]>()));
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
            low_degrees: "1",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: true,
            source: "definition",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(WhiteSquare::new(n_points)?))
    }
}
