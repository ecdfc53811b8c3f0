use sphvar_samplers::{Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::{Resolution, Spectrum, SpectrumAccumulator, accumulate};

use crate::{
    BiasTest, Effort, Energy, Error, Integrand, Measurement, PredictedPoint, Prediction,
    PredictionAccumulator, VariancePoint, measure, measure_until,
};

/// A pattern's spectrum, the variance that it predicts for an integrand, and the variance measured
/// on independent realizations.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The mean spectrum of the pattern.
    pub spectrum: Spectrum,
    /// The variance predicted from it.
    pub prediction: Prediction,
    /// The estimates of the trials.
    pub measurement: Measurement,
    /// The exact integral, if it is known.
    pub exact: Option<f64>,
    /// The variance that the rounding of an estimate alone can make.
    pub rounding: f64,
}

impl Comparison {
    /// Measured over predicted variance and the standard error of this ratio.
    #[must_use]
    pub fn ratio(&self) -> (f64, f64) {
        if self.missed() {
            return (f64::NAN, f64::NAN);
        }
        let measured = self.measurement.variance();
        let ratio = measured / self.prediction.variance;
        let relative = (self.measurement.variance_stderr() / measured)
            .hypot(self.prediction.total_stderr() / self.prediction.variance);
        (ratio, ratio * relative)
    }

    /// The difference of measured and predicted variance in units of the standard error that it has if the
    /// prediction is right, to which the rounding of the estimates is added; close to standard normal
    /// where the theory holds and trials are many.
    ///
    /// ```text
    /// z = (s^2 - V)/sqrt((V r)^2 + e^2 + rounding^2)
    /// ```
    ///
    /// V and e are the prediction and its [`total_stderr`](Prediction::total_stderr), r is the relative standard error
    /// of the measured s^2. With `s^2 r` instead of `V r` the score would lean to the negative side, as
    /// measured errors are small where measured variances are.
    /// NaN if no trial saw the integrand.
    #[must_use]
    pub fn z_score(&self) -> f64 {
        if self.missed() {
            return f64::NAN;
        }
        let expected = self.prediction.variance;
        let stderr = (expected * self.measurement.relative_stderr())
            .hypot(self.prediction.total_stderr())
            .hypot(self.rounding);
        (self.measurement.variance() - expected) / stderr
    }

    /// Whether the mean of the trials is the exact integral, if that is known and the trials saw the integrand.
    #[must_use]
    pub fn bias(&self) -> Option<BiasTest> {
        let exact = self.exact.filter(|_| !self.missed())?;
        Some(self.measurement.bias(exact, self.rounding))
    }

    /// Whether the trials have no variance although one is predicted: an integrand so small that none of them saw
    /// it, which says nothing.
    fn missed(&self) -> bool {
        self.measurement.variance() <= self.rounding && self.prediction.variance > self.rounding
    }

    /// The measured variance at its number of points, for rates and crossovers; 0 where it is no more
    /// than rounding.
    #[must_use]
    pub fn measured_point(&self) -> VariancePoint {
        self.point(self.measurement.variance(), self.measurement.variance_stderr())
    }

    /// The predicted variance at its number of points, likewise.
    #[must_use]
    pub fn predicted_point(&self) -> VariancePoint {
        self.point(self.prediction.variance, self.prediction.total_stderr())
    }

    fn point(&self, variance: f64, stderr: f64) -> VariancePoint {
        let n_points = self.spectrum.n_points() as f64;
        if variance > self.rounding {
            VariancePoint { n_points, variance, stderr }
        } else {
            VariancePoint { n_points, variance: 0.0, stderr: 0.0 }
        }
    }
}

/// What [`compare`] reports of its progress, in seconds, roughly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Work {
    /// A piece of work is done.
    Done(f64),
    /// More is to be done than [`Effort::seconds`] said: trials that a precision needs.
    Added(f64),
}

/// Predicts and measures the variance of integrating `integrand`, whose energies are `energy`, with
/// uniformly rotated realizations of `sampler`.
///
/// If the prediction is `known`, as from a [`Predictor`](crate::Predictor), it is taken as it is, and the effort's
/// lmax and realizations mean nothing.
///
/// # Errors
///
/// [`Error::Spectrum`] if the spectrum cannot be computed.
pub fn compare(
    sampler: &dyn Sampler,
    integrand: &dyn Integrand,
    energy: &Energy,
    effort: Effort,
    known: Option<PredictedPoint>,
    report: &(dyn Fn(Work) + Sync),
) -> Result<Comparison, Error> {
    let n_points = sampler.n_points();
    let (spectrum, prediction) = if let Some(PredictedPoint { spectrum, prediction }) = known {
        (spectrum, prediction)
    } else {
        estimate(sampler, energy, effort, report)?
    };
    let streams = Streams::new(effort.seed, Purpose::Trial, effort.group);
    let trials = Realizations::rotated(sampler, streams);
    let cost = effort.trial_seconds(n_points);
    let done = || report(Work::Done(cost));
    // An estimate of int F is a sum of numbers of the size of F, whose roundings partly cancel.
    let size = sampler.domain().area() * energy.total();
    let rounding = size * (4.0 * f64::EPSILON).powi(2);
    // No number of trials makes the variance of roundings precise.
    let until = effort.until.filter(|_| prediction.variance > rounding);
    let measurement = match until {
        None => measure(&trials, integrand, effort.trials, &done)?,
        Some(target) => {
            let expected = std::cell::Cell::new(effort.trials);
            let expect = |total: u64| {
                let more = total.saturating_sub(expected.replace(total)) as f64;
                report(Work::Added(cost * more));
            };
            measure_until(&trials, integrand, effort.trials, target, &expect, &done)?
        }
    };
    Ok(Comparison {
        spectrum,
        prediction,
        measurement,
        exact: integrand.exact(sampler.domain()),
        rounding,
    })
}

/// The spectrum from realizations, and the prediction with the covariance of its degrees.
fn estimate(
    sampler: &dyn Sampler,
    energy: &Energy,
    effort: Effort,
    report: &(dyn Fn(Work) + Sync),
) -> Result<(Spectrum, Prediction), Error> {
    let n_points = sampler.n_points();
    let Effort { seed, group, lmax, method, epsilon, .. } = effort;
    let empty = (
        SpectrumAccumulator::new(sampler.domain(), n_points, lmax),
        PredictionAccumulator::new(energy, n_points, lmax),
    );
    let resolution = Resolution { lmax, n_points, method, epsilon };
    let cost = effort.realization_seconds(n_points);
    let sets = Realizations::rotated(sampler, Streams::new(seed, Purpose::Pattern, group));
    let realizations = effort.distinct_realizations(sampler);
    let (spectrum, prediction) =
        accumulate(&sets, resolution, 0..realizations, &empty, &|| report(Work::Done(cost)))?;
    let (mut spectrum, mut prediction) = (spectrum.finish()?, prediction.finish());
    if !sampler.is_random() {
        spectrum = spectrum.into_exact();
        prediction = Prediction { stderr: 0.0, dof: f64::INFINITY, ..prediction };
    }
    Ok((spectrum, prediction))
}
