use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, SetDistribution, Streams};

use crate::{DirectionMode, DirectionSets, Error};

/// The maximum number of directions in a table with more than the minimum number of sets; 24 bytes
/// each.
const TABLE_DIRECTIONS: usize = 1 << 18;
/// The maximum number of sets in a table.
const MAX_SETS: usize = 1024;
/// The minimum number of sets in a table.
const MIN_SETS: usize = 4;
/// The maximum nominal work for generating a table of sets.
const TABLE_WORK: f64 = 1.6e6;

/// The assignment of directions to the hit points of renders.
///
/// Values are functions of (seed, render, pixel): they do not depend on threads or on the rendered
/// part of the image. Different renders have independent directions, as far as the mode is random.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionPlan {
    pattern: Pattern,
    n_points: usize,
    /// The number of points of a set.
    set_points: usize,
    mode: DirectionMode,
    /// The number of sets in a table; `None` if all sets of the pattern are equal.
    n_sets: Option<usize>,
    seed: u64,
    group: usize,
}

impl DirectionPlan {
    /// Returns the plan for `n_points` directions on the visible hemisphere, with a table of
    /// [`Self::default_sets`] sets.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if the pattern does not support that number of points, see
    /// [`Self::nearest_count`].
    pub fn new(
        pattern: Pattern,
        n_points: usize,
        mode: DirectionMode,
        seed: u64,
    ) -> Result<Self, Error> {
        let set_points = set_points(&pattern, n_points, mode);
        let sampler = pattern.build(set_points, mode.domain())?;
        let n_sets = sampler.is_random().then(|| Self::default_sets(&pattern, n_points));
        let group = match sampler.distribution() {
            SetDistribution::OneOf(_) => sampler.stream_group(),
            _ => pattern.stream_group(n_points),
        };
        Ok(Self { pattern, n_points, set_points, mode, n_sets, seed, group })
    }

    /// Returns the plan for a reference image: jittered antipodal sets with the nearest valid count
    /// above `n_points`, independent of every plan with the same seed.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if `n_points` is 0 or exceeds the range of indices.
    pub fn reference(n_points: usize, seed: u64) -> Result<Self, Error> {
        let mode = DirectionMode::Antipodal;
        let nearest = Pattern::Jittered.nearest_count(n_points, Domain::Hemisphere);
        // Zero directions are rejected below.
        let mut n = if n_points == 0 { 0 } else { nearest };
        if n < n_points {
            // Valid counts are 6 nside^2.
            let nside = (n / 6).isqrt() + 1;
            n = nside.saturating_mul(nside).saturating_mul(6);
        }
        let plan = Self::new(Pattern::Jittered, n, mode, seed)?;
        Ok(Self { group: !plan.group, ..plan })
    }

    /// Returns the plan with tables of `n_sets` sets, at least 1. The number matters only for
    /// [`DirectionMode::Rotated`] and [`DirectionMode::Antipodal`], and only for random patterns.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Setting`] for tables without sets.
    pub fn with_sets(self, n_sets: usize) -> Result<Self, Error> {
        check_sets(n_sets)?;
        Ok(Self { n_sets: self.n_sets.map(|_| n_sets), ..self })
    }

    /// Returns the valid number of directions of the pattern nearest to `requested`: a valid count
    /// on the hemisphere, or half of one on the sphere, rounded up.
    ///
    /// Both are the same numbers for most patterns. They differ for point files and for
    /// `mcewen-wiaux`, whose nodes have no antipodal symmetry.
    #[must_use]
    pub fn nearest_count(pattern: &Pattern, requested: usize, mode: DirectionMode) -> usize {
        match mode.domain() {
            Domain::Hemisphere => pattern.nearest_count(requested, Domain::Hemisphere),
            Domain::Sphere => {
                pattern.nearest_count(requested.saturating_mul(2), Domain::Sphere).div_ceil(2)
            }
        }
    }

    /// Returns the default number of sets in a table: as many as have 262144 directions together,
    /// or as can be generated in a tenth of a second on one core by [`Pattern::nominal_work`] if
    /// that is fewer, but between 4 and 1024.
    ///
    /// Sets with uniform random rotations give every pixel an unbiased mean and independent pixels,
    /// whatever their number. A small number of sets may be better or worse than the average set.
    #[must_use]
    pub fn default_sets(pattern: &Pattern, n_points: usize) -> usize {
        sets_of_work(pattern.nominal_work(n_points), n_points)
    }

    /// Returns the pattern.
    #[must_use]
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Returns the number of directions on the visible hemisphere; for halves of sphere sets, the
    /// expected number.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the number of points of a set: twice [`Self::n_points`] for sphere sets, or one less
    /// if the pattern has an odd number only.
    #[must_use]
    pub fn set_points(&self) -> usize {
        self.set_points
    }

    /// Returns the mode.
    #[must_use]
    pub fn mode(&self) -> DirectionMode {
        self.mode
    }

    /// Returns the number of sets that one render uses: 1 if the mode or the pattern has only one,
    /// 0 if every pixel has a separate set.
    #[must_use]
    pub fn n_sets(&self) -> usize {
        match self.mode {
            DirectionMode::Shared | DirectionMode::Spun => 1,
            DirectionMode::Rotated | DirectionMode::Antipodal => self.n_sets.unwrap_or(1),
            DirectionMode::Fresh => 0,
        }
    }

    /// Returns whether a render uses a table of several sets, so that [`Self::with_sets`] has an
    /// effect.
    #[must_use]
    pub fn has_table(&self) -> bool {
        let from_table = matches!(self.mode, DirectionMode::Rotated | DirectionMode::Antipodal);
        from_table && self.n_sets.is_some()
    }

    /// Returns the number of distinct sets in `renders` renders: 1 if all sets of the pattern are
    /// equal, 0 if every pixel has a separate set.
    #[must_use]
    pub fn distinct_sets(&self, renders: u64) -> u64 {
        match self.n_sets {
            None => 1,
            Some(_) => renders.saturating_mul(self.n_sets() as u64),
        }
    }

    /// Returns the sets of one render, generated in parallel.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if a set cannot be generated, and [`Error::TooManyRenders`] from
    /// render 2^24 on.
    pub fn prepare(&self, render: u64) -> Result<DirectionSets, Error> {
        if render >= DirectionSets::MAX_RENDERS {
            return Err(Error::TooManyRenders { max: DirectionSets::MAX_RENDERS });
        }
        let domain = self.mode.domain();
        let sampler = self.pattern.build(self.set_points, domain)?;
        let ensemble = Realizations::unrotated(
            &*sampler,
            Streams::new(self.seed, Purpose::Pattern, self.group),
        );
        let n_sets = self.n_sets() as u64;
        let sets: Result<Vec<_>, Error> = (0..n_sets)
            .into_par_iter()
            .map(|k| Ok(ensemble.realize(render * n_sets + k)?))
            .collect();
        let sets = sets?;
        let streams = Streams::new(self.seed, Purpose::Trial, self.group);
        Ok(DirectionSets::new(self.mode, self.n_points, sets, sampler, streams, render))
    }
}

/// Returns the number of points of the sets that have `n_points` visible directions.
fn set_points(pattern: &Pattern, n_points: usize, mode: DirectionMode) -> usize {
    let points = mode.set_points(n_points);
    let is_valid = |points: usize| pattern.nearest_count(points, mode.domain()) == points;
    let is_odd = mode.domain() == Domain::Sphere && !is_valid(points);
    if is_odd && points > 1 && is_valid(points - 1) { points - 1 } else { points }
}

/// Returns the default number of sets of this nominal work and number of points in a table.
pub(super) fn sets_of_work(nominal_work: f64, n_points: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and the cast saturates"
    )]
    let in_time = (TABLE_WORK / nominal_work) as usize;
    (TABLE_DIRECTIONS / n_points.max(1)).min(in_time).clamp(MIN_SETS, MAX_SETS)
}

/// Rejects tables without sets.
pub(super) fn check_sets(n_sets: usize) -> Result<(), Error> {
    let name = "the number of sets of a table";
    let error = Error::Setting { name, range: "at least 1", got: 0.0 };
    if n_sets == 0 { Err(error) } else { Ok(()) }
}
