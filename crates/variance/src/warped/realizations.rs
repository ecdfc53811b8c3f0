use glam::DVec3;
use sphvar_integrands::{Heuristic, Strategy};
use sphvar_samplers::{
    Ensemble, Error, PointSet, Progress, Purpose, SquareRealizations, SquareSampler, Streams,
};
use sphvar_warps::WarpSample;

use super::strategy_group;

/// The sets of directions of warped patterns with the weights of their estimates: realization `i` is
/// a function of (seed, purpose, samplers, i) alone, and the points are those of the trials of
/// [`WarpedPredictor`](super::WarpedPredictor).
///
/// An integral is estimated by `sum_k w_k f(s_k)`, with the weights 1/(N p) of one density, and
/// `w_i/(N_i p_i)` of several. Other than for quadrature rules, they are not divided by their sum,
/// which is a random number with the mean 4 pi (2 pi on the hemisphere) if the densities cover the
/// domain.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Domain, NoFiles};
/// use sphvar_samplers::Purpose;
/// use sphvar_variance::{WarpedPattern, WarpedRealizations};
///
/// let pattern: WarpedPattern = "sobol:warp=cosine".parse()?;
/// let strategies = pattern.warp.strategies(Domain::Hemisphere, &NoFiles)?;
/// let samplers = pattern.samplers(16)?;
/// let sets = WarpedRealizations::new(&strategies, pattern.heuristic, &samplers, 0, Purpose::Pattern);
/// let set = sets.realize(3)?;
/// let integral: f64 = set.points.iter().zip(&set.weights).map(|(s, w)| w * s.z).sum();
/// // The density is proportional to the function.
/// assert!((integral - std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct WarpedRealizations<'a> {
    strategies: &'a [Strategy],
    heuristic: Heuristic,
    samplers: &'a [Box<dyn SquareSampler>],
    seed: u64,
    purpose: Purpose,
    are_prefixes: bool,
}

impl<'a> WarpedRealizations<'a> {
    /// Returns the ensemble of the sets of samplers on the square, one for each strategy.
    #[must_use]
    pub fn new(
        strategies: &'a [Strategy],
        heuristic: Heuristic,
        samplers: &'a [Box<dyn SquareSampler>],
        seed: u64,
        purpose: Purpose,
    ) -> Self {
        Self { strategies, heuristic, samplers, seed, purpose, are_prefixes: false }
    }

    /// Returns the ensemble of the sets that draw from the streams of sequences
    /// ([`SquareSampler::sequence_group`]) where the samplers have them: the points of each strategy
    /// are then the first points of larger sets, and differ from those of trials.
    #[must_use]
    pub fn of_prefixes(self) -> Self {
        Self { are_prefixes: true, ..self }
    }

    /// Replaces `set` by realization `index`, strategy by strategy, and ticks the samplers' nominal
    /// work.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`SquareRealizations::realize_into`].
    pub fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        set.start();
        let (mut square, mut samples) = (PointSet::default(), Vec::<WarpSample>::new());
        for (i, (strategy, sampler)) in self.strategies.iter().zip(self.samplers).enumerate() {
            let shared = sampler.sequence_group().filter(|_| self.are_prefixes);
            let group = shared.unwrap_or_else(|| sampler.stream_group()) ^ strategy_group(i);
            let streams = Streams::new(self.seed, self.purpose, group);
            let sets = SquareRealizations::shifted(&**sampler, streams);
            sets.realize_into(index, &mut square, progress)?;
            strategy.warp.sample_into(&square.points, &mut samples);
            let (sum, _) = square.weight_sums();
            for (k, sample) in samples.iter().enumerate() {
                let share = square.weights.get(k).copied().unwrap_or(1.0) / sum;
                let weight = self.heuristic.weighted(self.strategies, i, *sample);
                set.points.push(sample.point);
                // The density is 0 in no more than single directions.
                set.weights.push(if weight.is_finite() { share * weight } else { 0.0 });
            }
        }
        Ok(())
    }

    /// Returns realization `index`.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::realize_into`].
    pub fn realize(&self, index: u64) -> Result<PointSet, Error> {
        let mut set = PointSet::default();
        self.realize_into(index, &mut set, &())?;
        Ok(set)
    }
}

impl Ensemble<DVec3> for WarpedRealizations<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Self::realize_into(self, index, set, progress)
    }
}
