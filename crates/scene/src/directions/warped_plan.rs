use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_integrands::Heuristic;
use sphvar_samplers::{PointSet, Purpose, SquarePattern, SquareRealizations, Streams};

use super::plan::sets_of_work;
use super::warped_sets::{SampledDensity, WarpedSets};
use crate::{Density, DirectionSets, Error};

/// Directions by importance sampling: sets of a pattern of the square, mapped at each hit point.
///
/// Every hit point takes a set of a table, shifts it modulo 1 by a uniform random vector and maps it
/// by the densities, with weights 1/(N p). Estimates are unbiased, and the errors of pixels are
/// uncorrelated. Several densities have independent sets, whose sizes are shares of N, and the
/// weights of a heuristic for multiple importance sampling (Veach 1997, section 9.2).
///
/// Values are functions of (seed, render, pixel), as those of
/// [`DirectionPlan`](crate::DirectionPlan).
///
/// # Examples
///
/// ```
/// use std::sync::Arc;
/// use sphvar_integrands::Heuristic;
/// use sphvar_samplers::SquarePattern;
/// use sphvar_scene::{CornellBox, Density, Estimator, Integral, LightMap, View, WarpedPlan, render};
///
/// let cornell = CornellBox::new();
/// let view = View::new(&cornell.scene, &cornell.camera, [16, 16])?;
/// let light = Density::Light { light: cornell.light, map: LightMap::Automatic };
/// let plan = WarpedPlan::new(SquarePattern::SOBOL, vec![(light, 1.0)], 16, Heuristic::Balance, 0)?;
/// let integral = Integral::Light { light: &cornell.light, albedo: 1.0 };
/// let image = render(&view, &integral, Estimator::Unbiased, &plan.prepare(0)?, &())?;
/// assert!(image.mean() > 0.0);
/// # Ok::<(), sphvar_scene::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct WarpedPlan {
    pattern: SquarePattern,
    strategies: Vec<Strategy>,
    heuristic: Heuristic,
    /// The number of sets in a table; `None` if all sets of the pattern are equal.
    n_sets: Option<usize>,
    seed: u64,
    group: usize,
}

/// A density with its nominal share of the points and their number.
#[derive(Clone, Debug)]
struct Strategy {
    density: Density,
    share: f64,
    n_points: usize,
}

impl WarpedPlan {
    /// Returns the plan for densities with their shares of `n_points`, which need not sum to 1. Each
    /// density takes the valid number of points of the pattern nearest to its share; densities
    /// without a share are left out.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Setting`] for a share that is negative or not finite, or if all are 0,
    /// [`Error::NoDirections`] for a map to the disk, and [`Error::Sampler`] if the pattern cannot be
    /// built.
    pub fn new(
        pattern: SquarePattern,
        densities: Vec<(Density, f64)>,
        n_points: usize,
        heuristic: Heuristic,
        seed: u64,
    ) -> Result<Self, Error> {
        let total: f64 = densities.iter().map(|(_, share)| share).sum();
        let wrong = |got| Error::Setting {
            name: "the share of a density",
            range: "finite and not negative, and one of them above 0",
            got,
        };
        if let Some((_, share)) = densities.iter().find(|(_, c)| !(*c >= 0.0 && c.is_finite())) {
            return Err(wrong(*share));
        }
        if !(total > 0.0 && total.is_finite()) {
            return Err(wrong(total));
        }
        let (mut strategies, mut group, mut is_random) = (Vec::new(), 0, false);
        for (density, share) in densities.into_iter().filter(|(_, share)| *share > 0.0) {
            density.check()?;
            let share = share / total;
            let n_points = pattern.nearest_count(nearest(share * n_points as f64));
            let sampler = pattern.build(n_points)?;
            group = sampler.stream_group();
            is_random = sampler.is_random();
            strategies.push(Strategy { density, share, n_points });
        }
        let count = strategies.iter().map(|s| s.n_points).max().unwrap_or(1);
        let n_sets = is_random.then(|| sets_of_work(pattern.nominal_work(count), count));
        Ok(Self { pattern, strategies, heuristic, n_sets, seed, group })
    }

    /// Returns the plan of a reference image, independent of every plan with the same seed.
    #[must_use]
    pub fn into_reference(self) -> Self {
        Self { group: !self.group, ..self }
    }

    /// Returns the plan with tables of `n_sets` sets; the number matters only for random patterns.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Setting`] for tables without sets.
    pub fn with_sets(self, n_sets: usize) -> Result<Self, Error> {
        super::plan::check_sets(n_sets)?;
        Ok(Self { n_sets: self.n_sets.map(|_| n_sets), ..self })
    }

    /// Returns the pattern of the square.
    #[must_use]
    pub fn pattern(&self) -> &SquarePattern {
        &self.pattern
    }

    /// Returns the number of directions at each point, over all densities.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.strategies.iter().map(|s| s.n_points).sum()
    }

    /// Returns the densities with their shares of the points, which sum to 1.
    pub fn densities(&self) -> impl Iterator<Item = (&Density, f64)> {
        self.strategies.iter().map(|s| (&s.density, s.share))
    }

    /// Returns the number of sets for each density in a render: 1 if all sets of the pattern are
    /// equal.
    #[must_use]
    pub fn n_sets(&self) -> usize {
        self.n_sets.unwrap_or(1)
    }

    /// Returns whether a render uses a table of several sets, so that [`Self::with_sets`] has an
    /// effect.
    #[must_use]
    pub fn has_table(&self) -> bool {
        self.n_sets.is_some()
    }

    /// Returns the nominal work of the sets of a render.
    #[must_use]
    pub fn table_work(&self) -> f64 {
        let of_set = |s: &Strategy| self.pattern.nominal_work(s.n_points);
        self.n_sets() as f64 * self.strategies.iter().map(of_set).sum::<f64>()
    }

    /// Returns the nominal work of mapping the directions of a point.
    #[must_use]
    pub fn map_work(&self) -> f64 {
        let densities = self.strategies.len() as f64;
        let of_strategy = |s: &Strategy| s.n_points as f64 * s.density.nominal_work();
        densities * self.strategies.iter().map(of_strategy).sum::<f64>()
    }

    /// Returns the sets of one render, generated in parallel.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if a set cannot be generated, and [`Error::TooManyRenders`] from
    /// render 2^24 on.
    pub fn prepare(&self, render: u64) -> Result<WarpedSets, Error> {
        if render >= DirectionSets::MAX_RENDERS {
            return Err(Error::TooManyRenders { max: DirectionSets::MAX_RENDERS });
        }
        let n_sets = self.n_sets() as u64;
        let prepared = |(number, strategy): (usize, &Strategy)| {
            let sampler = self.pattern.build(strategy.n_points)?;
            let streams = Streams::new(self.seed, Purpose::Pattern, self.group ^ salt(number));
            let ensemble = SquareRealizations::unshifted(&*sampler, streams);
            let sets: Result<Vec<PointSet<[f64; 2]>>, Error> = (0..n_sets)
                .into_par_iter()
                .map(|k| Ok(ensemble.realize(render * n_sets + k)?))
                .collect();
            Ok(SampledDensity::new(strategy.density.clone(), strategy.share, sets?))
        };
        let densities: Result<Vec<_>, Error> =
            self.strategies.iter().enumerate().map(prepared).collect();
        let streams = Streams::new(self.seed, Purpose::Trial, self.group);
        let n_points = self.n_points();
        Ok(WarpedSets::new(densities?, self.heuristic, n_points, self.map_work(), streams, render))
    }
}

/// Returns a number that distinguishes the streams of densities with equal numbers of points.
fn salt(strategy: usize) -> usize {
    // 2^32 divided by the golden ratio; 0 for the first density.
    strategy.wrapping_mul(0x9e37_79b9)
}

/// Returns the integer nearest to a number that is not negative.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and the cast saturates"
)]
fn nearest(x: f64) -> usize {
    x.round() as usize
}
