mod linear_form;
mod within_strata;

use std::ops::Range;

use sphvar_samplers::{
    Domain, PointSet, Progress, Purpose, Realizations, Sampler, SetDistribution, Share, Streams,
};
use sphvar_spectrum::{StrataQuadrature, accumulate};

use self::linear_form::{LinearForm, LinearFormAccumulator};
use crate::estimates::estimates;
use crate::predictor::realization_work;
use crate::{
    Error, Experiment, Measurement, PredictedPoint, Predictor, RelativeError, measure, trial_work,
};

/// The errors of integrating one function with a sampler that is not rotated.
///
/// A sampler whose sets are always the same has one error, and a distribution of errors over
/// uniformly random orientations. A random pattern in its own orientation has a distribution of
/// errors over its realizations, whose variance may differ from that of rotated realizations.
#[derive(Clone, Debug)]
pub struct FixedOrientation {
    /// The variance for uniformly rotated realizations, [`Predictor::predict`].
    pub rotated: PredictedPoint,
    /// The exact integral, if it is known.
    pub exact: Option<f64>,
    /// The estimate of a set that is always the same, in its own orientation; `None` for a random
    /// pattern.
    pub given: Option<f64>,
    /// The estimates of the trials: a set that is always the same in uniformly random
    /// orientations, or realizations of a random pattern in its own orientation.
    pub measurement: Measurement,
    /// The predicted variance of a random pattern in its own orientation; `None` for a set that is
    /// always the same, for which the variance over orientations is that of `rotated`.
    pub unrotated: Option<UnrotatedPrediction>,
    /// The variance that rounding of an estimate alone can produce.
    pub rounding: f64,
}

/// The predicted variance of a random pattern in its own orientation.
///
/// With `I_N = (area/sum w) sum_lm S_lm conj F_lm` the variance is the sum of
/// `Cov(S_lm, S_l'm') conj F_lm F_l'm'` over all pairs of coefficients. Without rotation no pair
/// vanishes in general. A symmetry of the distribution removes pairs: invariance under the
/// rotation by 90 degrees about z, which HEALPix cells have, leaves only m - m' divisible by 4,
/// and invariance under x -> -x only l - l' even.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UnrotatedPrediction {
    /// The variance.
    pub variance: f64,
    /// Its standard error, or the error of its quadrature.
    pub stderr: f64,
    /// How it was computed.
    pub method: UnrotatedMethod,
    /// The terms with l = l' and m = m' alone, `(area/sum w)^2 sum_lm <|S_lm|^2> |F_lm|^2`, with
    /// their standard error; `None` for independent points, which have no other terms, and for
    /// given sets.
    pub diagonal: Option<(f64, f64)>,
}

/// How the variance of an unrotated pattern is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum UnrotatedMethod {
    /// Independent points have the same variance in every orientation.
    Isotropic,
    /// `(area/N)^2 sum_k Var_k F` over strata with one independent point each, by quadrature.
    WithinStrata,
    /// From all of the given sets, one of which is drawn.
    AllSets,
    /// From realizations of `sum_lm S_lm conj F_lm` to the largest degree of the spectrum, with the
    /// energy beyond it as for rotated realizations.
    LinearForm,
}

impl UnrotatedMethod {
    /// Returns the name of the method.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::WithinStrata => "within-strata",
            Self::AllSets => "all-sets",
            Self::LinearForm => "linear-form",
        }
    }
}

/// The part of a [`FixedOrientation`] that needs no trials.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedOrientationPrediction {
    rotated: PredictedPoint,
    given: Option<f64>,
    unrotated: Option<UnrotatedPrediction>,
}

impl FixedOrientation {
    /// Returns the errors from a prediction, what is known of the trials, and their estimates.
    #[must_use]
    pub fn new(
        prediction: FixedOrientationPrediction,
        experiment: &Experiment,
        estimates: Vec<f64>,
    ) -> Self {
        let FixedOrientationPrediction { rotated, given, unrotated } = prediction;
        Self {
            rotated,
            exact: experiment.exact(),
            given,
            measurement: Measurement::new(estimates),
            unrotated,
            rounding: experiment.rounding(),
        }
    }

    /// Returns the variance that the trials measure, as predicted, and its standard error.
    #[must_use]
    pub fn predicted(&self) -> (f64, f64) {
        let rotated = self.rotated.prediction;
        self.unrotated
            .map_or((rotated.variance, rotated.total_stderr()), |p| (p.variance, p.stderr))
    }

    /// Returns the relative error of the measured variance, from the trials.
    #[must_use]
    pub fn error(&self) -> RelativeError {
        self.measurement.relative_error()
    }

    /// Returns whether the measured variance has an error: it exceeds the rounding of estimates,
    /// and enough trials carry it.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.measurement.variance() > self.rounding && self.error().is_known()
    }

    /// Returns measured minus predicted variance in standard errors; NaN where
    /// [the error is not known](Self::is_known).
    #[must_use]
    pub fn z_score(&self) -> f64 {
        if !self.is_known() {
            return f64::NAN;
        }
        let (variance, stderr) = self.predicted();
        let measured = self.measurement.variance();
        // The error under the hypothesis that the prediction is right.
        let trials = variance * self.error().at(variance / measured);
        (measured - variance) / trials.hypot(stderr)
    }

    /// Returns the error of an estimate, 0 within rounding.
    fn error_of(&self, estimate: f64) -> Option<f64> {
        let error = estimate - self.exact?;
        Some(if error * error > self.rounding { error } else { 0.0 })
    }

    /// Returns the error of a set that is always the same in its own orientation, with its sign.
    #[must_use]
    pub fn signed_error(&self) -> Option<f64> {
        self.error_of(self.given?)
    }

    /// Returns the mean error over the trials and its standard error, the bias of a random pattern
    /// in its own orientation.
    #[must_use]
    pub fn mean_error(&self) -> Option<(f64, f64)> {
        Some((self.error_of(self.measurement.mean())?, self.measurement.mean_stderr()))
    }

    /// Returns the largest error of a trial or of the given set, with its sign.
    #[must_use]
    pub fn worst_error(&self) -> Option<f64> {
        let estimates = self.measurement.estimates().iter().copied().chain(self.given);
        let errors = estimates.map(|estimate| self.error_of(estimate));
        let errors: Option<Vec<f64>> = errors.collect();
        errors?.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Returns the error that a share `p` of the trials does not exceed; see
    /// [`Measurement::quantile`].
    #[must_use]
    pub fn error_quantile(&self, p: f64) -> Option<f64> {
        self.error_of(self.measurement.quantile(p)?)
    }
}

impl Predictor<'_> {
    /// Returns the errors of a sampler that is not rotated, from this number of trials. Ticks
    /// [`Self::fixed_orientation_work`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] and [`measure`], and those of
    /// [`Integrand::coefficients`](sphvar_integrands::Integrand::coefficients) for random patterns.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Pattern};
    /// use sphvar_integrands::Harmonic;
    /// use sphvar_variance::{PredictionBudget, Predictor};
    ///
    /// let y = Harmonic::new(4, 0)?;
    /// let mut predictor = Predictor::new(&y, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
    /// let jittered = Pattern::Jittered.build(768, Domain::Sphere)?;
    /// let fixed = predictor.fixed_orientation(&*jittered, 100, &())?;
    /// // The cells prefer this axis.
    /// let ratio = fixed.predicted().0 / fixed.rotated.prediction.variance;
    /// assert!((ratio - 1.1156).abs() < 1e-3);
    /// # Ok::<(), sphvar_variance::Error>(())
    /// ```
    pub fn fixed_orientation(
        &mut self,
        sampler: &dyn Sampler,
        trials: u64,
        progress: &dyn Progress,
    ) -> Result<FixedOrientation, Error> {
        let prediction = self.predict_fixed_orientation(sampler, progress)?;
        let estimates = self.fixed_orientation_estimates(sampler, 0..trials, progress)?;
        Ok(FixedOrientation::new(prediction, &self.experiment(sampler), estimates))
    }

    /// Returns the part of [`Self::fixed_orientation`] that needs no trials. Ticks [`Self::work`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::fixed_orientation`].
    pub fn predict_fixed_orientation(
        &mut self,
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<FixedOrientationPrediction, Error> {
        let share = Share::new(progress, self.work(sampler)?);
        let rotated = self.predict(sampler, &share)?;
        share.finish()?;
        if sampler.is_random() {
            let unrotated = Some(self.predict_unrotated(sampler, &rotated, progress)?);
            return Ok(FixedOrientationPrediction { rotated, unrotated, given: None });
        }
        let streams = Streams::new(self.seed(), Purpose::Pattern, sampler.stream_group());
        let own = Realizations::unrotated(sampler, streams);
        let given = measure(&own, self.integrand(), 1, &())?.estimates().first().copied();
        Ok(FixedOrientationPrediction { rotated, unrotated: None, given })
    }

    /// Returns the estimates of the given trials of [`Self::fixed_orientation`], in their order. Ticks
    /// [`trial_work`] for each.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`measure`].
    pub fn fixed_orientation_estimates(
        &self,
        sampler: &dyn Sampler,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let streams = Streams::new(self.seed(), Purpose::Trial, sampler.stream_group());
        let sets = if sampler.is_random() {
            Realizations::unrotated(sampler, streams)
        } else {
            Realizations::rotated(sampler, streams)
        };
        estimates(self.domain(), &sets, self.integrand(), trials, progress)
    }

    /// Returns the nominal work of [`Self::fixed_orientation`], for progress.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::work`].
    pub fn fixed_orientation_work(
        &mut self,
        sampler: &dyn Sampler,
        trials: u64,
    ) -> Result<f64, Error> {
        Ok(self.work(sampler)? + trials as f64 * trial_work(sampler))
    }

    fn predict_unrotated(
        &mut self,
        sampler: &dyn Sampler,
        rotated: &PredictedPoint,
        progress: &dyn Progress,
    ) -> Result<UnrotatedPrediction, Error> {
        let whole = rotated.prediction;
        let lmax = rotated.spectrum.lmax();
        match sampler.distribution() {
            SetDistribution::Independent | SetDistribution::SphericalEnsemble => {
                Ok(UnrotatedPrediction {
                    variance: whole.variance,
                    stderr: whole.total_stderr(),
                    method: UnrotatedMethod::Isotropic,
                    diagonal: None,
                })
            }
            SetDistribution::OneOf(sets) => {
                let estimates = self.estimates_of_sets(sets, progress)?;
                let n = sets.len() as f64;
                // The ensemble is these sets themselves, so the divisor is their number.
                let variance = Measurement::new(estimates).variance() * (n - 1.0) / n;
                let method = UnrotatedMethod::AllSets;
                Ok(UnrotatedPrediction { variance, stderr: 0.0, method, diagonal: None })
            }
            kind => {
                let form = self.linear_form(sampler, lmax, progress)?;
                let tail_error = whole.tail_error;
                let diagonal = form.diagonal.mean() + whole.tail;
                let diagonal = Some((diagonal, form.diagonal.standard_error().hypot(tail_error)));
                let strata = match kind {
                    SetDistribution::Stratified(strata) => {
                        StrataQuadrature::new(strata, self.domain())
                    }
                    _ => None,
                };
                if let Some(strata) = strata {
                    let (variance, stderr) = within_strata::variance(
                        &strata,
                        self.domain(),
                        self.integrand(),
                        lmax,
                        progress,
                    )?;
                    let method = UnrotatedMethod::WithinStrata;
                    return Ok(UnrotatedPrediction { variance, stderr, method, diagonal });
                }
                let values = Measurement::new(form.values());
                let variance = values.variance();
                let stderr = (variance * values.relative_error().relative()).hypot(tail_error);
                let method = UnrotatedMethod::LinearForm;
                let variance = variance + whole.tail;
                Ok(UnrotatedPrediction { variance, stderr, method, diagonal })
            }
        }
    }

    /// Accumulates the linear form over as many realizations as the budget allows.
    fn linear_form(
        &mut self,
        sampler: &dyn Sampler,
        lmax: usize,
        progress: &dyn Progress,
    ) -> Result<LinearForm, Error> {
        let streams = Streams::new(self.seed(), Purpose::Pattern, sampler.stream_group());
        let sets = Realizations::unrotated(sampler, streams);
        let count = self.max_realizations(self.budget(), sampler, &lmax);
        progress.expect(count as f64 * realization_work::<Domain>(sampler, &lmax));
        let coefficients = self.integrand().coefficients(self.domain(), lmax)?.to_alm()?;
        let empty = LinearFormAccumulator::new(coefficients, self.domain());
        let resolution = self.resolution(lmax, sampler.n_points());
        Ok(accumulate(&sets, resolution, 0..count, &empty, progress)?.finish())
    }

    /// Returns the estimates of given sets in their order.
    fn estimates_of_sets(
        &self,
        sets: &[PointSet],
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let area = self.domain().area();
        let mut values = Vec::new();
        let mut estimate = |set: &PointSet| {
            values.clear();
            values.resize(set.len(), 0.0);
            self.integrand().eval_into(&set.points, &mut values)?;
            progress.tick(0.0)?;
            Ok(area * set.mean(&values))
        };
        sets.iter().map(&mut estimate).collect()
    }
}
