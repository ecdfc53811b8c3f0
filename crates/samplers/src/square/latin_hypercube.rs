use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;

use super::POINTS_PER_TICK;
use super::jittered_square::within;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, Square, SquareDistribution,
    SquareSampler, count,
};

/// Latin hypercube samples: each of the N strips of width 1/N in u and each of those in v holds one
/// uniform point, in a uniform random order.
///
/// On the axes of the frequencies the power is that of jittered points in one dimension; off the
/// axes it is close to 1. With `sinc x = sin(pi x)/(pi x)`, `k1, k2 != 0` and N > 1,
///
/// ```text
/// P(k1, 0) = 1 - sinc^2(k1/N),   P(k1, k2) = 1 + sinc^2(k1/N) sinc^2(k2/N)/(N - 1).
/// ```
///
/// Two points are in different strips of u and, independently, of v: each coordinate contributes the
/// factor `-sinc^2(k/N)/(N - 1)` to the N - 1 correlations of a point.
///
/// # References
///
/// M. D. `McKay`, R. J. Beckman and W. J. Conover, "A comparison of three methods for selecting
/// values of input variables in the analysis of output from a computer code", Technometrics 21
/// (1979).
#[derive(Clone, Copy, Debug)]
pub struct LatinHypercube {
    n: u32,
}

impl LatinHypercube {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for LatinHypercube {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::LatinHypercube
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        let mut strips: Vec<u32> = (0..self.n).collect();
        for row in 0..self.n {
            if row.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            // The shuffle of Fisher and Yates, one step for each point.
            let chosen = rng.random_range(row..self.n) as usize;
            strips.swap(row as usize, chosen);
            let [u, v]: [f64; 2] = rng.random();
            points.push([within(row, self.n, u), within(strips[row as usize], self.n, v)]);
        }
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
            low_degrees: "1 off the axes, pi^2 k^2/(3 N^2) on them",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: false,
            source: "McKay, Beckman and Conover 1979",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(LatinHypercube::new(n_points)?))
    }
}
