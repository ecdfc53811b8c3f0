use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Realizations;

use crate::{Error, Integrand};

/// The estimates that trials of a pattern gave of one integral.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    estimates: Vec<f64>,
}

impl Measurement {
    /// From the estimates of independent trials.
    #[must_use]
    pub fn new(estimates: Vec<f64>) -> Self {
        Self { estimates }
    }

    /// The estimates in the order of the trials.
    #[must_use]
    pub fn estimates(&self) -> &[f64] {
        &self.estimates
    }

    /// The mean estimate; NaN of no trials.
    #[must_use]
    pub fn mean(&self) -> f64 {
        // The second pass takes out the rounding of the first.
        let rough = self.estimates.iter().sum::<f64>() / self.count();
        rough + self.estimates.iter().map(|x| x - rough).sum::<f64>() / self.count()
    }

    /// The standard error of the mean; NaN of fewer than two trials.
    #[must_use]
    pub fn mean_stderr(&self) -> f64 {
        (self.variance() / self.count()).sqrt()
    }

    /// The unbiased variance of the estimates, divisor count - 1; NaN of fewer than two trials.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.estimates.len() < 2 { f64::NAN } else { self.moment(2) / (self.count() - 1.0) }
    }

    /// The standard error of the variance, from the fourth moment of the estimates:
    /// `Var s^2 = (mu_4 - sigma^4 (n-3)/(n-1))/n`. NaN of fewer than four trials.
    #[must_use]
    pub fn variance_stderr(&self) -> f64 {
        let n = self.count();
        if n < 4.0 {
            return f64::NAN;
        }
        let fourth = self.moment(4) / n;
        let square = self.variance() * self.variance();
        // The moments are estimates: for two-valued trials the difference can round below 0.
        ((fourth - square * (n - 3.0) / (n - 1.0)).max(0.0) / n).sqrt()
    }

    /// The sum of the deviations' `k`-th powers.
    fn moment(&self, k: i32) -> f64 {
        let mean = self.mean();
        self.estimates.iter().map(|x| (x - mean).powi(k)).sum()
    }

    fn count(&self) -> f64 {
        self.estimates.len() as f64
    }
}

/// Integrates `integrand` by `trials` realizations of an ensemble, `area/N sum_k f(s_k)` each, in
/// parallel; `done` is called after each.
///
/// # Errors
///
/// [`Error::Spectrum`] with the sampler's error if a realization cannot be made.
pub fn measure(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    trials: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Measurement, Error> {
    let area = ensemble.sampler().domain().area();
    let trial = |points: &mut Vec<DVec3>, index| {
        ensemble.realize_into(index, points).map_err(sphvar_spectrum::Error::from)?;
        let mean = points.iter().map(|&p| integrand.eval(p)).sum::<f64>() / points.len() as f64;
        done();
        Ok(area * mean)
    };
    // Collected in the order of the trials: what follows does not depend on threads.
    let estimates: Result<Vec<f64>, Error> =
        (0..trials).into_par_iter().map_init(Vec::new, trial).collect();
    Ok(Measurement::new(estimates?))
}

#[cfg(test)]
mod tests {
    use super::Measurement;

    #[test]
    fn moments_are_those_of_the_definition() {
        let m = Measurement::new(vec![1.0, 2.0, 4.0, 9.0]);
        assert!((m.mean() - 4.0).abs() < 1e-15);
        // Deviations -3, -2, 0, 5: squares 38, fourth powers 722.
        assert!((m.variance() - 38.0 / 3.0).abs() < 1e-14);
        let square = (38.0f64 / 3.0).powi(2);
        let expected = ((722.0 / 4.0 - square / 3.0) / 4.0).sqrt();
        assert!((m.variance_stderr() - expected).abs() < 1e-14);
    }

    #[test]
    fn a_common_offset_does_not_hurt() {
        let offset = 1e8;
        let m = Measurement::new((0..100).map(|k| offset + 1e-6 * f64::from(k % 2)).collect());
        // Deviations round to offset EPSILON = 2e-8, one part in 50.
        assert!((m.variance() / (0.25e-12 * 100.0 / 99.0) - 1.0).abs() < 0.1, "{:e}", m.variance());
    }
}
