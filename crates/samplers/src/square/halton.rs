use rand::Rng;
use sphvar_grammar::Parametric;

use super::radical_inverse::{base_2, base_3};
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Rate, Square, SquareDistribution, SquareSampler,
    count,
};

/// The first N points of the Halton sequence in bases 2 and 3 (Halton 1960).
///
/// Point i, from 0, is `(phi_2(i), phi_3(i))` with the radical inverses phi. The set is not random;
/// [`Shifted`](crate::Shifted) makes it so.
#[derive(Clone, Copy, Debug)]
pub struct Halton {
    n: u32,
}

impl Halton {
    /// Returns the pattern of the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for Halton {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        set.start().extend((0..self.n).map(|i| [base_2(i), base_3(i)]));
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
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Halton 1960",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(Halton::new(n_points)?))
    }
}
