use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};

use crate::{DirectionMode, DirectionSets, Error};

/// Directions of a table if it has more sets than the fewest, at most: 24 bytes each.
const TABLE_DIRECTIONS: usize = 1 << 18;
/// Sets of a table, at most.
const MOST_SETS: usize = 1024;
/// Sets of a table, at least.
const FEWEST_SETS: usize = 4;
/// The nominal work that a table of sets may take.
const TABLE_WORK: f64 = 1.6e6;

/// Which directions the hit points of renders have.
///
/// Values are functions of (seed, render, pixel): neither threads nor the part of the image that is rendered
/// show in them. Different renders have independent directions, as far as the mode has randomness.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionPlan {
    pattern: Pattern,
    n_points: usize,
    mode: DirectionMode,
    /// Of a table; `None` if all sets of the pattern are the same.
    n_sets: Option<usize>,
    seed: u64,
    group: usize,
}

impl DirectionPlan {
    /// The plan for `n_points` directions on the visible hemisphere, with a table of
    /// [`Self::usual_sets`] sets.
    ///
    /// # Errors
    /// [`Error::Sampler`] if the pattern does not exist with that many points, see [`Self::nearest_count`].
    pub fn new(
        pattern: Pattern,
        n_points: usize,
        mode: DirectionMode,
        seed: u64,
    ) -> Result<Self, Error> {
        let sampler = pattern.build(mode.set_points(n_points), mode.domain())?;
        let n_sets = sampler.is_random().then(|| Self::usual_sets(&pattern, n_points));
        let group = pattern.stream_group(n_points);
        Ok(Self { pattern, n_points, mode, n_sets, seed, group })
    }

    /// The plan for a reference image: jittered lines, of the nearest number above `n_points` that they have,
    /// independent of every plan for the same seed.
    ///
    /// # Errors
    /// [`Error::Sampler`] for 0 or more points than indices can count.
    pub fn reference(n_points: usize, seed: u64) -> Result<Self, Error> {
        let mode = DirectionMode::Projective;
        let nearest = Pattern::Jittered.nearest_count(n_points, Domain::Hemisphere);
        // No directions at all are refused below.
        let mut n = if n_points == 0 { 0 } else { nearest };
        if n < n_points {
            // Numbers are 6 nside^2.
            let nside = (n / 6).isqrt() + 1;
            n = nside.saturating_mul(nside).saturating_mul(6);
        }
        let plan = Self::new(Pattern::Jittered, n, mode, seed)?;
        Ok(Self { group: !plan.group, ..plan })
    }

    /// The same with tables of `n_sets` sets, at least 1. It matters for [`DirectionMode::Rotated`] and
    /// [`DirectionMode::Projective`] only, and for patterns that are random.
    ///
    /// # Errors
    /// [`Error::Setting`] for tables without sets.
    pub fn with_sets(self, n_sets: usize) -> Result<Self, Error> {
        if n_sets == 0 {
            let name = "the number of sets of a table";
            return Err(Error::Setting { name, range: "at least 1", got: 0.0 });
        }
        Ok(Self { n_sets: self.n_sets.map(|_| n_sets), ..self })
    }

    /// The number of directions nearest to `asked` with which the pattern exists.
    ///
    /// The numbers are the same for all modes: those of the hemisphere, the halves of those of the sphere.
    #[must_use]
    pub fn nearest_count(pattern: &Pattern, asked: usize) -> usize {
        pattern.nearest_count(asked, Domain::Hemisphere)
    }

    /// How many sets a table has unless another number is wished: as many as have 262144 directions
    /// together, or take a tenth of a second to make on one core by [`Pattern::nominal_work`] if that is fewer, but from 4
    /// to 1024.
    ///
    /// Sets that are turned uniformly give every pixel the right mean and pixels that do not depend on
    /// each other, however few they are; but a few sets may be better or worse than most.
    #[must_use]
    pub fn usual_sets(pattern: &Pattern, n_points: usize) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number, and too large ones become the largest"
        )]
        let in_time = (TABLE_WORK / pattern.nominal_work(n_points)) as usize;
        (TABLE_DIRECTIONS / n_points.max(1)).min(in_time).clamp(FEWEST_SETS, MOST_SETS)
    }

    /// The pattern.
    #[must_use]
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The number of directions on the visible hemisphere; of halves of sphere sets the expected one.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> DirectionMode {
        self.mode
    }

    /// The number of sets that one render draws on: 1 if the mode or the pattern has no more, 0 if every pixel has
    /// its own.
    #[must_use]
    pub fn n_sets(&self) -> usize {
        match self.mode {
            DirectionMode::Shared | DirectionMode::Spun => 1,
            DirectionMode::Rotated | DirectionMode::Projective => self.n_sets.unwrap_or(1),
            DirectionMode::Fresh => 0,
        }
    }

    /// Whether a render draws on a table of several sets, so that [`Self::with_sets`] matters.
    #[must_use]
    pub fn has_table(&self) -> bool {
        let from_table = matches!(self.mode, DirectionMode::Rotated | DirectionMode::Projective);
        from_table && self.n_sets.is_some()
    }

    /// The number of different sets in so many renders together: 1 if all sets of the pattern are the same, 0 if every
    /// pixel has its own.
    #[must_use]
    pub fn distinct_sets(&self, renders: u64) -> u64 {
        match self.n_sets {
            None => 1,
            Some(_) => renders.saturating_mul(self.n_sets() as u64),
        }
    }

    /// Makes the sets of one render, in parallel.
    ///
    /// # Errors
    /// [`Error::Sampler`] if a set cannot be completed, [`Error::TooManyRenders`] from 2^24 on.
    pub fn prepare(&self, render: u64) -> Result<DirectionSets, Error> {
        if render >= DirectionSets::MAX_RENDERS {
            return Err(Error::TooManyRenders { max: DirectionSets::MAX_RENDERS });
        }
        let domain = self.mode.domain();
        let sampler = self.pattern.build(self.mode.set_points(self.n_points), domain)?;
        let ensemble = Realizations::unrotated(
            &*sampler,
            Streams::new(self.seed, Purpose::Pattern, self.group),
        );
        let n_sets = self.n_sets() as u64;
        let sets: Result<Vec<_>, Error> = (0..n_sets)
            .into_par_iter()
            .map(|k| Ok(ensemble.realize(render * n_sets + k)?.points.into_boxed_slice()))
            .collect();
        let sets = sets?;
        let streams = Streams::new(self.seed, Purpose::Trial, self.group);
        Ok(DirectionSets::new(self.mode, self.n_points, sets, sampler, streams, render))
    }
}
