use std::ops::Range;

use sphvar_samplers::{Domain, Progress, Purpose, Sampler};
use sphvar_sh::Bands;

use crate::estimates::{estimates, trial_work_of};
use crate::known_moments::{KnownMoments, SumsOfWeights};
use crate::space::IntegrationSpace;
use crate::stopping::until;
use crate::{Comparison, Error, Measurement, Precision, Prediction, PredictorOn};

/// The number of trials from which a variance is measured, fixed or by a requested precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trials {
    /// The number of trials, or the initial number if `until` is given.
    pub count: u64,
    /// The requested precision; `None` for a fixed number of trials.
    pub until: Option<Precision>,
}

impl Trials {
    /// Returns a fixed number of trials.
    #[must_use]
    pub const fn new(count: u64) -> Self {
        Self { count, until: None }
    }

    /// The default number of trials of a sampler whose sets are inexpensive to make: the standard error of a
    /// measured variance is then about 4.5 % of it.
    pub const DEFAULT: u64 = 1000;
    /// The default number of trials at least, however expensive the sets are: an error of about 20 %.
    pub const MIN_DEFAULT: u64 = 50;
    /// The nominal work of the default trials of one variance, about two and a half seconds of one core, unless
    /// [`Self::MIN_DEFAULT`] trials take more.
    const DEFAULT_WORK: f64 = 4e7;

    /// Returns the default number of trials for a sampler: 1000, for samplers whose sets are expensive to make as
    /// many as a fixed nominal work allows, but at least 50. It is the same on every machine.
    #[must_use]
    pub fn default_of<S: IntegrationSpace>(sampler: S::SamplerRef<'_>) -> Self {
        Self::default_of_work(trial_work_of::<S>(sampler))
    }

    /// Returns [`Self::default_of`] for trials of a nominal work.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number, and the cast saturates"
    )]
    pub(crate) fn default_of_work(work: f64) -> Self {
        let affordable = (Self::DEFAULT_WORK / work) as u64;
        Self::new(affordable.clamp(Self::MIN_DEFAULT, Self::DEFAULT))
    }

    /// Returns [`Self::default_of`] for a sampler of directions.
    #[must_use]
    pub fn default_for(sampler: &dyn Sampler) -> Self {
        Self::default_of::<Domain>(sampler)
    }

    /// Returns the nominal work of `count` trials.
    #[must_use]
    pub fn work(&self, sampler: &dyn Sampler) -> f64 {
        self.work_of::<Domain>(sampler)
    }

    /// Returns [`Self::work`] for a sampler of any space.
    #[must_use]
    pub fn work_of<S: IntegrationSpace>(&self, sampler: S::SamplerRef<'_>) -> f64 {
        self.count as f64 * trial_work_of::<S>(sampler)
    }
}

impl<S: IntegrationSpace> PredictorOn<'_, S> {
    /// Returns the predicted and the measured variance for a sampler with uniformly rotated
    /// realizations, by [`Self::predict`], which also has the spectrum, and [`Self::measure`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] and [`Self::measure`].
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Pattern};
    /// use sphvar_integrands::ClampedCosine;
    /// use sphvar_variance::{PredictionBudget, Predictor, Trials};
    ///
    /// let mut predictor =
    ///     Predictor::new(&ClampedCosine, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
    /// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
    /// let compared = predictor.compare(&*jittered, Trials::new(400), &())?;
    /// assert!(compared.z_score().abs() < 4.0);
    /// # Ok::<(), sphvar_variance::Error>(())
    /// ```
    pub fn compare(
        &mut self,
        sampler: S::SamplerRef<'_>,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        let predicted = self.predict(sampler, progress)?;
        self.measure(predicted.prediction, sampler, trials, progress)
    }

    /// Returns the comparison of a prediction with the variance measured from the same seed, on
    /// realizations independent of those of the prediction. Ticks [`Trials::work`]; additional work
    /// that the precision needs is announced first.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`measure`](crate::measure) and [`measure_until`](crate::measure_until).
    pub fn measure(
        &self,
        prediction: Prediction,
        sampler: S::SamplerRef<'_>,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        let mut source = |trials| self.estimates(sampler, trials, progress);
        self.experiment(sampler).measure(&mut source, prediction, trials, progress)
    }

    /// Returns the estimates of the integral from the given trials of [`Self::measure`], in their
    /// order. Ticks [`trial_work`](crate::trial_work) for each.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`measure`](crate::measure).
    pub fn estimates(
        &self,
        sampler: S::SamplerRef<'_>,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let sets = self.realizations(Purpose::Trial, sampler);
        estimates(self.space(), &sets, self.integrand(), trials, progress)
    }

    /// Returns what is known of the trials with a sampler. Its roundings are those of the energies
    /// that have been computed so far ([`Self::prepare`]).
    #[must_use]
    pub fn experiment(&self, sampler: S::SamplerRef<'_>) -> Experiment {
        Experiment {
            n_points: S::n_points(sampler),
            work: trial_work_of::<S>(sampler),
            exact: self.space().integral(self.integrand()),
            rounding: self.estimate_rounding(),
            prediction_rounding: self.energy().prediction_rounding(),
            known: self.known_moments(sampler),
        }
    }

    fn known_moments(&self, sampler: S::SamplerRef<'_>) -> KnownMoments {
        let n_points = S::n_points(sampler);
        let weights = SumsOfWeights::of::<S>(S::given_sets(sampler));
        let variance = self.energy().bands().factor(1) * self.energy().beyond(0);
        let squares = weights.map_or((n_points as f64).recip(), |weights| weights.squares);
        KnownMoments {
            n_points: weights.map_or(n_points as f64, SumsOfWeights::equal_points),
            independent_variance: variance * squares,
            one_point_variance: variance,
            kurtosis: self.kurtosis(),
            one_point_kurtosis: self.kurtosis(),
            is_independent: S::is_independent(sampler),
        }
    }

    /// Returns the variance that rounding of an estimate alone can produce: an estimate of int F is
    /// a sum of numbers of the size of F, whose roundings partly cancel.
    pub(crate) fn estimate_rounding(&self) -> f64 {
        self.space().area() * self.energy().total() * (4.0 * f64::EPSILON).powi(2)
    }
}

/// What is known of the trials of a pattern before they are made, as returned by
/// [`PredictorOn::experiment`]: with it, the estimates of trials that were made anywhere become a
/// [`Comparison`].
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_integrands::ClampedCosine;
/// use sphvar_variance::{Measurement, PredictionBudget, Predictor, Trials};
///
/// let mut predictor =
///     Predictor::new(&ClampedCosine, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
/// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
/// let prediction = predictor.predict(&*jittered, &())?.prediction;
/// let mut estimates = predictor.estimates(&*jittered, 0..60, &())?;
/// estimates.extend(predictor.estimates(&*jittered, 60..100, &())?);
/// let compared =
///     predictor.experiment(&*jittered).comparison(prediction, Measurement::new(estimates));
/// let in_one = predictor.measure(prediction, &*jittered, Trials::new(100), &())?;
/// assert_eq!(compared.measurement, in_one.measurement);
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Experiment {
    pub(crate) n_points: usize,
    /// The nominal work of a trial.
    pub(crate) work: f64,
    /// The exact integral.
    pub(crate) exact: Option<f64>,
    /// The variance that rounding of an estimate alone can produce.
    pub(crate) rounding: f64,
    /// The variance that rounding of the prediction alone can produce.
    pub(crate) prediction_rounding: f64,
    pub(crate) known: KnownMoments,
}

impl Experiment {
    /// Returns what is known of trials that each add one estimate of every experiment, whose
    /// expectations sum to `exact` if that is known.
    pub(crate) fn of_sum(parts: &[Self], exact: Option<f64>) -> Self {
        let known: Vec<KnownMoments> = parts.iter().map(|part| part.known).collect();
        Self {
            n_points: parts.iter().map(|part| part.n_points).sum(),
            work: parts.iter().map(|part| part.work).sum(),
            exact,
            rounding: parts.iter().map(|part| part.rounding).sum(),
            prediction_rounding: parts.iter().map(|part| part.prediction_rounding).sum(),
            known: KnownMoments::of_sum(&known),
        }
    }

    /// Returns the exact integral, if it is known.
    #[must_use]
    pub fn exact(&self) -> Option<f64> {
        self.exact
    }

    /// Returns the variance that rounding of an estimate alone can produce.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Returns the comparison of a prediction with the variance of trials, whose estimates `source`
    /// returns: those of consecutive ranges of trials, in their order.
    ///
    /// # Errors
    ///
    /// Returns the errors of `source` and of [`measure_until`](crate::measure_until).
    pub fn measure(
        &self,
        source: &mut dyn FnMut(Range<u64>) -> Result<Vec<f64>, Error>,
        prediction: Prediction,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        // No number of trials makes a variance due to rounding precise.
        let is_visible = prediction.is_unknown() || prediction.variance > self.rounding;
        let measurement = match trials.until.filter(|_| is_visible) {
            None => Measurement::new(source(0..trials.count)?),
            Some(target) => {
                let known = self.known.trials_for(target.relative, prediction.variance);
                let start = trials.count.max(known.min(target.max_trials));
                progress.expect((start - trials.count) as f64 * self.work);
                until(source, self.work, start, target, progress)?
            }
        };
        Ok(self.comparison(prediction, measurement))
    }

    /// Returns the comparison of a prediction with a measurement.
    #[must_use]
    pub fn comparison(&self, prediction: Prediction, measurement: Measurement) -> Comparison {
        Comparison {
            n_points: self.n_points,
            prediction,
            measurement,
            exact: self.exact,
            rounding: self.rounding,
            prediction_rounding: self.prediction_rounding,
            known: self.known,
        }
    }
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern};

    use super::Trials;
    use crate::trial_work;

    #[test]
    fn default_trials_follow_from_the_work_of_a_set() {
        let count = |name: &str, n: usize| {
            let sampler = name.parse::<Pattern>().unwrap().build(n, Domain::Sphere).unwrap();
            (Trials::default_for(&*sampler).count, trial_work(&*sampler))
        };
        assert_eq!(count("white-noise", 3072).0, Trials::DEFAULT);
        assert_eq!(count("riesz", 1 << 20).0, Trials::MIN_DEFAULT);
        let (few, work) = count("step", 432);
        assert!((Trials::MIN_DEFAULT..Trials::DEFAULT).contains(&few), "{few}");
        let budget = Trials::DEFAULT_WORK;
        assert!(few as f64 * work <= budget && (few + 1) as f64 * work > budget, "{few}");
    }
}
