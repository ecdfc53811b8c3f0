use std::ops::Range;

use sphvar_samplers::{Domain, Progress};

use super::measurement::{PrefixTrials, experiments, prefixes_together};
use super::prefixes::{KnownVariances, Prefixes, check_counts, unknown};
use super::space::{ProgressiveSpace, is_homogeneous};
use super::{ProgressiveCurve, ProgressivePoint, Randomized};
use crate::estimates::trial_work_of;
use crate::{Error, Experiment, PredictorOn};

/// Predicts and measures the variance of integrating one function with every prefix of a sequence.
///
/// Prefixes of one realization have the same points, so errors of neighbouring prefixes are
/// correlated. All prefixes share the random streams of the sequence.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::Cap;
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_variance::{PredictionBudget, Predictor, ProgressivePredictor, Randomized};
///
/// let cap = Cap::from_degrees(60.0)?;
/// let predictor = Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
/// let mut predictor = ProgressivePredictor::new(predictor);
/// let halton = "halton".parse::<Pattern>()?.build(64, Domain::Sphere)?;
/// // The random streams that sets of all numbers of points share.
/// let group = halton.sequence_group().ok_or("no sequence")?;
/// let counts = [16, 32, 64];
/// let curve = predictor.curve(&*halton, group, &counts, 400, Randomized::Rotated, &())?;
/// for point in curve.points {
///     assert!(point.measurement.unwrap().z.abs() < 4.0);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ProgressivePredictor<'a, S: ProgressiveSpace = Domain> {
    predictor: PredictorOn<'a, S>,
    known: KnownVariances<S::Point>,
}

impl<'a, S: ProgressiveSpace> ProgressivePredictor<'a, S> {
    /// Returns the predictor of prefixes with the integrand, the seed, the budget and the options of
    /// a predictor of single sets.
    #[must_use]
    pub fn new(predictor: PredictorOn<'a, S>) -> Self {
        Self { predictor, known: None }
    }

    /// Returns the predictor of single sets for the same integrand, such as those of a reference.
    pub fn of_sets(&mut self) -> &mut PredictorOn<'a, S> {
        &mut self.predictor
    }

    /// Returns the predicted variances of the prefixes with `counts` points, distinct and in
    /// increasing order, of a sequence that is uniformly rotated, on the square shifted. `group` is
    /// the number of the random streams of the sequence. Ticks at most [`Self::work`].
    ///
    /// Prefixes are predicted by the method that takes less work in total: all together, from sums
    /// over pairs of points, or each from its own spectrum. Single predictions share the work that
    /// the sums would take, so a few of them are as precise as those of
    /// [`PredictorOn::predict`](crate::PredictorOn::predict).
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] for counts that are not increasing or not between 1 and the
    /// number of points of the sampler, and the errors of
    /// [`PredictorOn::predict`](crate::PredictorOn::predict).
    pub fn predict(
        &mut self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        self.prefixes().predict(sampler, group, counts, progress)
    }

    /// Returns the predicted variances of whole sets of samplers in increasing order of their numbers
    /// of points, uniformly rotated, on the square shifted. They agree with those of
    /// [`PredictorOn::predict`](crate::PredictorOn::predict) within their errors; a set of N points costs
    /// about N^2/2 values of the kernel that prefixes have, less than a spectrum. Ticks at most
    /// [`Self::work_of_sets`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`PredictorOn::predict`](crate::PredictorOn::predict).
    pub fn predict_sets(
        &mut self,
        samplers: &[S::SamplerRef<'_>],
        progress: &dyn Progress,
    ) -> Result<Vec<ProgressivePoint>, Error> {
        self.prefixes().of_sets(samplers, progress)
    }

    /// Returns the maximum nominal work of [`Self::predict_sets`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict_sets`] that occur without a realization.
    pub fn work_of_sets(&mut self, samplers: &[S::SamplerRef<'_>]) -> Result<f64, Error> {
        self.prefixes().work_of_sets(samplers)
    }

    fn prefixes(&mut self) -> Prefixes<'_, 'a, S> {
        Prefixes { predictor: &mut self.predictor, known: &mut self.known }
    }

    /// Returns the curve with the variances measured from `trials` realizations, which are
    /// independent of those of the predictions. All prefixes of a trial are those of one
    /// realization.
    ///
    /// # Errors
    ///
    /// Returns the errors of the sampler and the integrand, and an error if `progress` stops the
    /// work.
    pub fn measure(
        &self,
        curve: ProgressiveCurve,
        sampler: S::SamplerRef<'_>,
        group: usize,
        trials: u64,
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        let of = PrefixTrials { sampler, group, randomized };
        let points = of.measured(&self.predictor, curve.points, trials, progress)?;
        Ok(ProgressiveCurve { points, ..curve })
    }

    /// Returns the estimates of the integral by some of the trials of [`Self::measure`], trial by
    /// trial, each with those of all prefixes of `counts`: 8 bytes each. Ticks
    /// [`Trials::work_of`](crate::Trials::work_of).
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] for counts that are not increasing or not between 1 and the
    /// number of points of the sampler, and the errors of [`Self::measure`].
    pub fn estimates(
        &self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
        trials: Range<u64>,
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        check_counts(counts, S::n_points(sampler))?;
        let of = PrefixTrials { sampler, group, randomized };
        of.estimates(&self.predictor, counts, trials, progress)
    }

    /// Returns the number of prefixes whose estimates by `trials` trials are kept in memory at a
    /// time, at most 512 MiB. [`Self::measure`] repeats the trials for more prefixes.
    #[must_use]
    pub fn prefixes_together(trials: u64) -> usize {
        prefixes_together(trials)
    }

    /// Returns what is known of the trials of each prefix. Its roundings are those of the energies
    /// that have been computed so far.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] for counts that are not increasing or not between 1 and the
    /// number of points of the sampler.
    pub fn experiments(
        &self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
    ) -> Result<Vec<Experiment>, Error> {
        check_counts(counts, S::n_points(sampler))?;
        experiments(&self.predictor, sampler, group, counts)
    }

    /// Returns whether the sets of a sampler are homogeneous, so that their variances are predicted.
    #[must_use]
    pub fn is_predicted(sampler: S::SamplerRef<'_>, randomized: Randomized) -> bool {
        randomized == Randomized::Rotated || is_homogeneous::<S>(sampler)
    }

    /// Returns [`Self::predict`] for sets that are homogeneous, otherwise
    /// [`Prediction::UNKNOWN`](crate::Prediction::UNKNOWN) for every prefix.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`].
    pub fn predict_known(
        &mut self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        if Self::is_predicted(sampler, randomized) {
            return self.predict(sampler, group, counts, progress);
        }
        check_counts(counts, S::n_points(sampler))?;
        Ok(unknown(counts))
    }

    /// Returns the predicted variances, where they are known, and the measured ones, unless `trials`
    /// is 0.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] and [`Self::measure`].
    pub fn curve(
        &mut self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
        trials: u64,
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        let curve = self.predict_known(sampler, group, counts, randomized, progress)?;
        if trials == 0 {
            return Ok(curve);
        }
        self.measure(curve, sampler, group, trials, randomized, progress)
    }

    /// Returns the maximum nominal work of [`Self::curve`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn work(
        &mut self,
        sampler: S::SamplerRef<'_>,
        counts: &[usize],
        trials: u64,
    ) -> Result<f64, Error> {
        let measured = trials as f64 * trial_work_of::<S>(sampler);
        Ok(measured + self.prefixes().work(sampler, counts)?)
    }
}
