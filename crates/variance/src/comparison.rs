use crate::known_moments::KnownMoments;
use crate::{BiasTest, Measurement, Prediction, RelativeError, VariancePoint};

/// The variance predicted from a pattern's spectrum and the variance measured on independent
/// realizations, as returned by [`Predictor::compare`](crate::Predictor::compare).
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The number of points N.
    pub n_points: usize,
    /// The predicted variance.
    pub prediction: Prediction,
    /// The estimates of the trials.
    pub measurement: Measurement,
    /// The exact integral, if it is known; of a vector, its norm.
    pub exact: Option<f64>,
    /// The variance that rounding of an estimate alone can produce.
    pub rounding: f64,
    /// The variance that rounding of the prediction alone can produce.
    pub(crate) prediction_rounding: f64,
    pub(crate) known: KnownMoments,
}

impl Comparison {
    /// The square of the rounding of a mean and of an exact integral, relative to that of the
    /// deviations of estimates, which share the roundings of a density and of the integral: 1e-13
    /// of the function.
    pub(crate) const BIAS_ROUNDING: f64 = 128.0 * 128.0;

    /// Returns the relative error of the measured variance, from the trials and the known moments
    /// of the integrand.
    #[must_use]
    pub fn error(&self) -> RelativeError {
        self.known.error(&self.measurement)
    }

    /// Returns whether too few trials hit the integrand's variation for an interval, a score, a
    /// ratio or a verdict ([`RelativeError::is_known`]), although there is a variance to measure.
    #[must_use]
    pub fn has_too_few_hits(&self) -> bool {
        self.is_visible() && (self.is_constant() || !self.error().is_known())
    }

    /// Returns whether the variance exceeds the rounding of estimates.
    fn is_visible(&self) -> bool {
        self.measurement.variance().max(self.prediction.variance) > self.rounding
    }

    /// Returns whether rounding of the integrand's values hides its variation: all estimates are
    /// bit-identical, although a variance is predicted, because that is below the rounding of
    /// estimates. The trials then measure nothing.
    #[must_use]
    pub fn is_rounded_away(&self) -> bool {
        let expected = self.prediction.variance;
        let is_hidden = expected > self.prediction_rounding && expected <= self.rounding;
        is_hidden && self.measurement.variance() == 0.0
    }

    /// Returns whether all trials gave the same estimate, up to rounding.
    fn is_constant(&self) -> bool {
        self.measurement.variance() <= self.rounding
    }

    /// Returns the end points of the measured variance's confidence interval, which contains the
    /// measured value.
    ///
    /// If all trials agree, the interval extends from 0 to an upper limit (97.5 %) from the moments
    /// of the integrand: equal estimates show only that others are rare. It is (0, 0) only if an
    /// exact prediction has no variance. Returns `None` if [too few trials hit the
    /// integrand](Self::has_too_few_hits).
    #[must_use]
    pub fn measured_interval(&self, confidence: f64) -> Option<(f64, f64)> {
        if !self.is_constant() {
            return self.error().interval(self.measurement.variance(), confidence);
        }
        let predicted = self.prediction.variance + self.prediction.total_stderr();
        if predicted <= self.rounding {
            return Some((0.0, predicted.max(self.measurement.variance())));
        }
        let offset = self.exact.map(|exact| self.measurement.mean() - exact);
        let limit = self.known.limit_unseen(self.measurement.estimates().len(), offset);
        Some((0.0, limit.max(self.measurement.variance())))
    }

    /// Returns the ratio of measured to predicted variance and the standard error of the ratio; NaN
    /// if too few trials hit the integrand, or if both variances are at most the rounding of
    /// estimates.
    #[must_use]
    pub fn ratio(&self) -> (f64, f64) {
        if self.has_too_few_hits() || !self.is_visible() {
            return (f64::NAN, f64::NAN);
        }
        let ratio = self.measurement.variance() / self.prediction.variance;
        let relative = self
            .error()
            .relative()
            .hypot(self.prediction.total_stderr() / self.prediction.variance);
        (ratio, ratio * relative)
    }

    /// Returns the difference of measured and predicted variance in units of its standard error
    /// under the hypothesis that the prediction is right; the rounding of the estimates is added to
    /// that error. It is close to standard normal if the theory holds and the number of trials is
    /// large.
    ///
    /// ```text
    /// z = (s^2 - V)/sqrt((V r)^2 + e^2 + rounding^2)
    /// ```
    ///
    /// V and e are the prediction and its [`total_stderr`](Prediction::total_stderr). r is the
    /// relative standard error of the measured s^2 if V is right: the exact one for independent
    /// points and an integrand of known kurtosis, otherwise [`RelativeError::at`] and at least that
    /// of values that few sets hit. With `s^2 r`
    /// instead of `V r` the score would be biased to negative values, as small measured variances
    /// have small measured errors. NaN if too few trials hit the integrand.
    #[must_use]
    pub fn z_score(&self) -> f64 {
        if self.has_too_few_hits() {
            return f64::NAN;
        }
        let (measured, expected) = (self.measurement.variance(), self.prediction.variance);
        // The relative error of mere rounding can have any value.
        let sampling = if self.is_constant() { 0.0 } else { expected * self.expected_error() };
        let stderr = sampling.hypot(self.prediction.total_stderr()).hypot(self.rounding);
        (measured - expected) / stderr
    }

    /// Returns the test of the mean of the trials against the exact integral, if that is known and
    /// enough trials hit the integrand.
    #[must_use]
    pub fn bias(&self) -> Option<BiasTest> {
        // The norm of a mean with errors is larger than that of the integrals.
        let is_testable = !self.has_too_few_hits() && !self.measurement.is_of_vector();
        let exact = self.exact.filter(|_| is_testable)?;
        Some(self.measurement.bias(exact, Self::BIAS_ROUNDING * self.rounding))
    }

    /// Returns the measured variance at its number of points, for rates and crossovers. The
    /// variance is 0 where it is at most rounding. Its error is infinite if too few trials hit the
    /// integrand, or if rounding hides an existing variance.
    ///
    /// The error is the one expected if the prediction is right, so that weighting by errors does
    /// not favour variances that happen to be small.
    #[must_use]
    pub fn measured_point(&self) -> VariancePoint {
        let variance = self.measurement.variance();
        let is_hidden = !self.is_visible() && self.prediction.variance > self.prediction_rounding;
        if self.has_too_few_hits() || is_hidden {
            let n_points = self.n_points as f64;
            return VariancePoint { n_points, variance, stderr: f64::INFINITY };
        }
        self.point(variance, variance * self.expected_error(), self.rounding)
    }

    /// Returns the relative standard error of the measured variance if the prediction is right; if
    /// the prediction is 0, the error from the trials alone.
    fn expected_error(&self) -> f64 {
        let ratio = self.prediction.variance / self.measurement.variance();
        let trials = self.measurement.estimates().len();
        let rare = self.known.rare_error(self.prediction.variance, trials);
        let by_trials = || self.error().at(if ratio > 0.0 { ratio } else { 1.0 }).max(rare);
        self.known.exact_error(trials).unwrap_or_else(by_trials)
    }

    /// Returns the predicted variance at its number of points, with the same conventions.
    #[must_use]
    pub fn predicted_point(&self) -> VariancePoint {
        let Prediction { variance, .. } = self.prediction;
        self.point(variance, self.prediction.total_stderr(), self.prediction_rounding)
    }

    /// Returns whether the prediction has the smaller relative error of the two. This holds where
    /// there is nothing to measure.
    #[must_use]
    pub fn is_prediction_more_precise(&self) -> bool {
        let relative =
            |p: VariancePoint| if p.variance > 0.0 { p.stderr / p.variance } else { 0.0 };
        let (predicted, measured) = (self.predicted_point(), self.measured_point());
        // An unknown error does not count as small.
        let is_known = !self.prediction.total_stderr().is_nan();
        is_known && (relative(predicted) <= relative(measured) || relative(measured).is_nan())
    }

    /// Returns the more precise of [`predicted_point`](Self::predicted_point) and
    /// [`measured_point`](Self::measured_point).
    #[must_use]
    pub fn best_point(&self) -> VariancePoint {
        if self.is_prediction_more_precise() {
            self.predicted_point()
        } else {
            self.measured_point()
        }
    }

    fn point(&self, variance: f64, stderr: f64, rounding: f64) -> VariancePoint {
        let n_points = self.n_points as f64;
        if variance > rounding || variance.is_nan() {
            VariancePoint { n_points, variance, stderr }
        } else {
            VariancePoint { n_points, variance: 0.0, stderr: 0.0 }
        }
    }
}
