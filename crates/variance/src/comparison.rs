use sphvar_samplers::{Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::{Method, Resolution, Spectrum, SpectrumAccumulator, accumulate};

use crate::{
    Energy, Error, Integrand, Measurement, Prediction, PredictionAccumulator, VariancePoint,
    measure,
};

/// How much work a [`Comparison`] may take, and from which random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// The seed of all streams.
    pub seed: u64,
    /// What tells the streams of this ensemble from those of others of one run, such as
    /// [`Pattern::stream_group`](sphvar_samplers::Pattern::stream_group).
    pub group: usize,
    /// The largest degree of the pattern's spectrum.
    pub lmax: usize,
    /// How the spectrum is computed.
    pub method: Method,
    /// The relative accuracy of coefficients by the fast method.
    pub epsilon: f64,
    /// Realizations from which the spectrum is estimated (one suffices a pattern that is not random).
    pub realizations: u64,
    /// Trials from which the variance is measured, independent of the realizations.
    pub trials: u64,
}

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
    /// The variance that the rounding of an estimate alone can make.
    pub rounding: f64,
}

impl Comparison {
    /// Measured over predicted variance and the standard error of this ratio.
    #[must_use]
    pub fn ratio(&self) -> (f64, f64) {
        let measured = self.measurement.variance();
        let ratio = measured / self.prediction.variance;
        let relative = (self.measurement.variance_stderr() / measured)
            .hypot(self.prediction.stderr / self.prediction.variance);
        (ratio, ratio * relative)
    }

    /// The difference of measured and predicted variance in units of its standard error, to which
    /// the rounding of the estimates is added; close to standard normal where the theory holds and
    /// trials are many.
    #[must_use]
    pub fn z_score(&self) -> f64 {
        let stderr = self.measurement.variance_stderr().hypot(self.prediction.stderr);
        let stderr = stderr.hypot(self.rounding);
        (self.measurement.variance() - self.prediction.variance) / stderr
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
        self.point(self.prediction.variance, self.prediction.stderr)
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

/// Predicts and measures the variance of integrating `integrand`, whose energies are `energy`, with
/// uniformly rotated realizations of `sampler`. `done` is called with a number of seconds, roughly,
/// after each piece of work.
///
/// # Errors
///
/// [`Error::Spectrum`] if the spectrum cannot be computed.
pub fn compare(
    sampler: &dyn Sampler,
    integrand: &dyn Integrand,
    energy: &Energy,
    effort: Effort,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Comparison, Error> {
    let n_points = sampler.n_points();
    let ensemble =
        |purpose| Realizations::rotated(sampler, Streams::new(effort.seed, purpose, effort.group));
    let realizations = distinct_realizations(sampler, effort.realizations);
    let empty = (
        SpectrumAccumulator::new(sampler.domain(), n_points, effort.lmax),
        PredictionAccumulator::new(energy, n_points, effort.lmax),
    );
    let resolution =
        Resolution { lmax: effort.lmax, n_points, method: effort.method, epsilon: effort.epsilon };
    let cost = realization_cost(n_points, effort.lmax, effort.method);
    let sets = ensemble(Purpose::Pattern);
    let (spectrum, prediction) =
        accumulate(&sets, resolution, 0..realizations, &empty, &|| done(cost))?;
    let cost = trial_cost(n_points);
    let measurement = measure(&ensemble(Purpose::Trial), integrand, effort.trials, &|| {
        done(cost);
    })?;
    // An estimate of int F is a sum of numbers of the size of F, whose roundings partly cancel.
    let size = sampler.domain().area() * energy.total();
    let (mut spectrum, mut prediction) = (spectrum.finish()?, prediction.finish());
    if !sampler.is_random() {
        spectrum = spectrum.into_exact();
        prediction.stderr = 0.0;
    }
    Ok(Comparison {
        spectrum,
        prediction,
        measurement,
        rounding: size * (4.0 * f64::EPSILON).powi(2),
    })
}

/// The seconds that [`compare`] reports in all.
#[must_use]
pub fn comparison_cost(sampler: &dyn Sampler, effort: Effort) -> f64 {
    let n_points = sampler.n_points();
    let realizations = distinct_realizations(sampler, effort.realizations);
    realizations as f64 * realization_cost(n_points, effort.lmax, effort.method)
        + effort.trials as f64 * trial_cost(n_points)
}

/// The degree to which a spectrum is needed for predicting the variance of an integrand, if the
/// caller has no wish of his own.
///
/// A random pattern's power is 1 beyond some 2 sqrt(N), so 4 sqrt(N) leave a tail that is known. A
/// lattice has peaks at all degrees whose mean only is 1: 40 sqrt(N), unless the integrand's energies
/// fall fast before that. Degrees that the integrand does not have are not needed.
#[must_use]
pub fn prediction_degree(sampler: &dyn Sampler, integrand: &dyn Integrand) -> usize {
    let law = Resolution::natural_degree(sampler.n_points());
    let degree = if sampler.is_random() { law } else { law.saturating_mul(10) };
    let resolved = integrand.resolved_degree().map_or(degree, |most| degree.min(most.max(law)));
    integrand.band_limit().map_or(resolved, |most| resolved.min(most))
}

/// How many realizations of `n_points` a spectrum to `lmax` is worth beside `trials` of the
/// measurement: eight times the work, but no fewer than 300 (or the trials, if these are fewer) and no
/// more than eight times the trials.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of realizations"
)]
pub fn worthwhile_realizations(n_points: usize, lmax: usize, trials: u64) -> u64 {
    let relative = trial_cost(n_points) / realization_cost(n_points, lmax, Method::Auto);
    let balanced = 8.0 * trials as f64 * relative;
    (balanced as u64).clamp(trials.min(300), trials.saturating_mul(8))
}

fn distinct_realizations(sampler: &dyn Sampler, realizations: u64) -> u64 {
    if sampler.is_random() { realizations } else { realizations.min(1) }
}

/// Seconds for making one realization and transforming it, roughly.
fn realization_cost(n_points: usize, lmax: usize, method: Method) -> f64 {
    n_points as f64 * 40e-9 + method.seconds(n_points, lmax)
}

/// Seconds for one trial: per point, making it and evaluating the integrand.
fn trial_cost(n_points: usize) -> f64 {
    n_points as f64 * 80e-9
}
