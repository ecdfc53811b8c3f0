mod bound_buckets;
mod candidate_cells;
mod cell_family;
mod cell_place;
mod near_sites;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use self::candidate_cells::CandidateCells;
use super::white_noise;
use crate::definition::Definition;
use crate::search::CubeGrid;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler, count};

/// The number of candidates up to which all are drawn, which takes less time than cells do.
const MAX_DRAWN: u64 = 1500;

/// The nominal work of a point by cells, over the cube root of the number of points: the bounds of
/// the cells around the farthest candidate are finer the more candidates there are.
const POINT_WORK: f64 = 100.0;

/// Best-candidate sampling (Mitchell 1991): each new point is the one of several uniform candidates
/// that is farthest from all previous points.
///
/// The n-th point is chosen among `factor (n - 1)` candidates, so that their density relative to
/// the points is constant. On the hemisphere distances are antipodal: the smaller of those to a
/// point and to its antipode. The distribution is invariant under rotations, so every single point
/// is uniform. Every N is valid, and the first n points are the pattern of n points.
///
/// Candidates that lie where another one is certainly farther are counted but not drawn: cells have
/// upper bounds of the distance of their points from the set, the number of candidates in the cells
/// with the largest bounds follows from their area, and these contain the farthest one. Up to 1500
/// candidates all are drawn. The cost grows as about `N^1.35`: 80 microseconds a point at N =
/// 16384, 130 at 60000.
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
        let (n, factor) = (f64::from(self.n), f64::from(self.factor));
        // The candidates of the first points are all drawn.
        let first = n.min(MAX_DRAWN as f64 / factor);
        0.8 * factor * first * first + POINT_WORK * n.cbrt() * (n - first)
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
        points.push(white_noise::uniform_direction(self.domain, rng));
        let share = self.nominal_work() / f64::from(self.n);
        let mut grid = CubeGrid::for_points(1);
        let mut crowded_at = 1;
        let mut cells = None;
        for n in 1..self.n {
            progress.tick(share)?;
            let n_candidates = u64::from(self.factor) * u64::from(n);
            if n_candidates > MAX_DRAWN {
                let cells = cells.get_or_insert_with(|| {
                    let last = points.len() - 1;
                    let clearance = self.nearest(&points[..last], points[last]);
                    CandidateCells::new(self.domain, points, clearance)
                });
                let next = cells.farthest(n_candidates, rng);
                cells.insert(next);
                points.push(self.domain.representative(next));
                continue;
            }
            if points.len() >= crowded_at {
                crowded_at = 2 * points.len();
                grid = CubeGrid::for_points(crowded_at);
                points.iter().for_each(|&p| grid.insert(p));
            }
            let mut best = DVec3::ZERO;
            // Below every squared distance, so that the first candidate is accepted.
            let mut clearance = -1.0;
            for _ in 0..n_candidates {
                let candidate = white_noise::uniform_direction(self.domain, rng);
                if let Some(farther) = self.clearance(&grid, points, candidate, clearance) {
                    (best, clearance) = (candidate, farther);
                }
            }
            points.push(best);
            grid.insert(best);
        }
        Ok(())
    }
}

impl BestCandidate {
    /// Returns the squared distance of `p` from the nearest point, or `None` if it does not exceed
    /// `bound`.
    fn clearance(&self, grid: &CubeGrid, points: &[DVec3], p: DVec3, bound: f64) -> Option<f64> {
        let above = grid.clearance(points, p, bound)?;
        match self.domain {
            Domain::Sphere => Some(above),
            Domain::Hemisphere => Some(above.min(grid.clearance(points, -p, bound)?)),
        }
    }

    /// Returns the distance of `p` from the nearest of `points`, 2 if there is none.
    fn nearest(&self, points: &[DVec3], p: DVec3) -> f64 {
        let distance = |q: &DVec3| match self.domain {
            Domain::Sphere => q.distance(p),
            Domain::Hemisphere => q.distance(p).min(q.distance(-p)),
        };
        points.iter().map(distance).fold(2.0, f64::min)
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
            // Between the square of few points and the power 4/3 of many.
            cost: CostOrder { exponent: 1.34, ..CostOrder::LINEAR },
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
