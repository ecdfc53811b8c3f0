use rand::Rng;
use sphvar_grammar::Parametric;

use super::radical_inverse::base_2;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Rate, Square, SquareDistribution, SquareSampler,
    count,
};

/// The Hammersley set of N points in base 2 (Hammersley 1960).
///
/// Point i is `((i + 1/2)/N, phi_2(i))` with the radical inverse phi. The set is not random;
/// [`Shifted`](crate::Shifted) makes it so.
#[derive(Clone, Copy, Debug)]
pub struct Hammersley {
    n: u32,
}

impl Hammersley {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for Hammersley {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        let n = f64::from(self.n);
        set.start().extend((0..self.n).map(|i| [(f64::from(i) + 0.5) / n, base_2(i)]));
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
            // Faster for N = 2^m.
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Hammersley 1960",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(Hammersley::new(n_points)?))
    }
}
