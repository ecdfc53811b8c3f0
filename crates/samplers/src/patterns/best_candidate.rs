mod bisector;
mod farthest;
mod sum_tree;
mod voronoi_edges;

use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use self::farthest::Farthest;
use super::white_noise;
use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler, count};

/// The nominal work of N points over `N^GROWTH`, fitted to times of 1000 to a million points.
const WORK: f64 = 65.0;
const GROWTH: f64 = 1.2;

/// Best-candidate sampling (Mitchell 1991): each new point is the one of several uniform candidates
/// that is farthest from all previous points.
///
/// The n-th point is chosen among `factor (n - 1)` candidates, so that their density relative to
/// the points is constant. On the hemisphere distances are antipodal: the smaller of those to a
/// point and to its antipode. The distribution is invariant under rotations, so every single point
/// is uniform. Every N is valid, and the first n points are the pattern of n points.
///
/// Candidates that lie where another one is certainly farther are counted but not drawn: the
/// Voronoi diagram of the points divides the directions farther than a level from all points into
/// regions of known area, from which the number of candidates there follows. The time hardly
/// depends on `factor` and grows as about `N^1.2`: 9 microseconds a point for N = 10^4, 20 for
/// 10^5, 37 for 10^6.
///
/// ```
/// use sphvar_samplers::{BestCandidate, Domain, Purpose, Sampler, Streams};
/// let sampler = BestCandidate::new(100, Domain::Sphere, BestCandidate::DEFAULT_FACTOR)?;
/// let points = sampler.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// assert_eq!(points.len(), 100);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BestCandidate {
    n: u32,
    domain: Domain,
    factor: u32,
}

impl BestCandidate {
    /// Candidates per existing point.
    pub const DEFAULT_FACTOR: u32 = 1;

    /// Returns the pattern of `n_points` points with `factor` candidates per existing point.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless both are from 1 to `u32::MAX`.
    pub fn new(n_points: usize, domain: Domain, factor: u32) -> Result<Self, Error> {
        if factor == 0 {
            let (name, range) = ("the candidates per point", "a whole number from 1");
            return Err(Error::Parameter { name, range, got: 0.0 });
        }
        Ok(Self { n: count::checked(n_points)?, domain, factor })
    }
}

impl Sampler for BestCandidate {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn nominal_work(&self) -> f64 {
        WORK * libm::pow(f64::from(self.n), GROWTH)
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        let first = white_noise::uniform_direction(self.domain, rng);
        points.push(first);
        let share = self.nominal_work() / f64::from(self.n);
        progress.tick(share)?;
        let mut farthest = Farthest::new(self.domain, first);
        for n in 1..self.n {
            progress.tick(share)?;
            let next = farthest.farthest(u64::from(self.factor) * u64::from(n), rng);
            points.push(self.domain.representative(next.direction));
            farthest.insert(next);
        }
        Ok(())
    }
}

/// Parameters of the pattern [`BestCandidate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestCandidateParameters {
    /// Candidates per existing point.
    pub factor: u32,
}

impl BestCandidateParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { factor: BestCandidate::DEFAULT_FACTOR };
}

impl Default for BestCandidateParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for BestCandidateParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "candidates for each point so far";
        d.integer("factor", [1, i64::from(u32::MAX)], summary, &mut self.factor);
    }
}

impl Definition for BestCandidateParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            // Measured, between 1000 and 10^5 points.
            cost: CostOrder { exponent: GROWTH, ..CostOrder::LINEAR },
            low_degrees: "0.075",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: true,
            source: "Mitchell 1991",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(BestCandidate::new(n_points, domain, self.factor)?))
    }
}
