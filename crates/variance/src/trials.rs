use sphvar_samplers::{Progress, Purpose, Realizations, Sampler, Streams};

use crate::known_moments::KnownMoments;
use crate::{
    Comparison, Error, Precision, PredictedPoint, Predictor, measure, measure_until, trial_work,
};
use sphvar_integrands::Integrand;

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

    /// Returns the nominal work of `count` trials.
    #[must_use]
    pub fn work(&self, sampler: &dyn Sampler) -> f64 {
        self.count as f64 * trial_work(sampler)
    }
}

impl Predictor<'_> {
    /// Predicts and measures the variance for a sampler, each of whose realizations is uniformly
    /// rotated: [`Self::predict`] and [`Self::measure`].
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Pattern};
    /// use sphvar_integrands::ClampedCosine;
    /// use sphvar_variance::{PredictionBudget, Predictor, Trials};
    ///
    /// let mut predictor =
    ///     Predictor::new(&ClampedCosine, Domain::Sphere, 0, PredictionBudget::USUAL)?;
    /// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
    /// let compared = predictor.compare(&*jittered, Trials::new(400), &())?;
    /// assert!(compared.z_score().abs() < 4.0);
    /// # Ok::<(), sphvar_variance::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Self::predict`] and [`Self::measure`].
    pub fn compare(
        &mut self,
        sampler: &dyn Sampler,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        let predicted = self.predict(sampler, progress)?;
        self.measure(predicted, sampler, trials, progress)
    }

    /// Measures the variance that was predicted, from the same seed but on realizations independent
    /// of those of the prediction. [`Trials::work`] is ticked; if the precision needs more, that is
    /// announced first.
    ///
    /// # Errors
    ///
    /// Those of [`measure`] and [`measure_until`].
    pub fn measure(
        &mut self,
        predicted: PredictedPoint,
        sampler: &dyn Sampler,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        let domain = self.domain();
        let integrand: &dyn Integrand = self.integrand();
        let kurtosis = self.kurtosis();
        let energy = self.energy();
        // An estimate of int F is a sum of numbers of the size of F, whose roundings partly cancel.
        let rounding = domain.area() * energy.total() * (4.0 * f64::EPSILON).powi(2);
        let prediction_rounding = energy.prediction_rounding();
        let known = KnownMoments {
            n_points: sampler.n_points() as f64,
            one_point_variance: domain.variance_factor(1) * energy.beyond(0),
            kurtosis,
            is_independent: sampler.is_independent(),
        };
        let streams = Streams::new(self.seed(), Purpose::Trial, sampler.stream_group());
        let sets = Realizations::rotated(sampler, streams);
        // No number of trials makes the variance of roundings precise.
        let until = trials.until.filter(|_| predicted.prediction.variance > rounding);
        let measurement = match until {
            None => measure(&sets, integrand, trials.count, progress)?,
            Some(target) => {
                let start = trials.count.max(known.trials_for(target.relative));
                progress.expect((start - trials.count) as f64 * trial_work(sampler));
                measure_until(&sets, integrand, start, target, progress)?
            }
        };
        let exact = integrand.exact(domain);
        Ok(Comparison { predicted, measurement, exact, rounding, prediction_rounding, known })
    }
}
