use sphvar_samplers::Sampler;
use sphvar_spectrum::Method;

use crate::Precision;

/// How much work a [`Comparison`](crate::Comparison) may take, and from which random numbers.
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
    /// Trials from which the variance is measured, independent of the realizations; with a
    /// precision asked for, those to begin with.
    pub trials: u64,
    /// How precisely the variance is to be measured, if not by a given number of trials.
    pub until: Option<Precision>,
    /// The seconds that making one set takes, roughly, such as
    /// [`Pattern::seconds`](sphvar_samplers::Pattern::seconds); for progress only.
    pub seconds_per_set: f64,
}

impl Effort {
    /// The seconds that [`compare`](crate::compare) reports in all, with no more trials than it begins with.
    #[must_use]
    pub fn seconds(&self, sampler: &dyn Sampler) -> f64 {
        self.distinct_realizations(sampler) as f64 * self.realization_seconds(sampler.n_points())
            + self.trials as f64 * self.trial_seconds(sampler.n_points())
    }

    pub(crate) fn distinct_realizations(&self, sampler: &dyn Sampler) -> u64 {
        if sampler.is_random() { self.realizations } else { self.realizations.min(1) }
    }

    /// Seconds for making one realization and transforming it, roughly.
    pub(crate) fn realization_seconds(&self, n_points: usize) -> f64 {
        self.seconds_per_set + self.method.seconds(n_points, self.lmax)
    }

    /// Seconds for making one trial's set and evaluating the integrand at its points.
    pub(crate) fn trial_seconds(&self, n_points: usize) -> f64 {
        self.seconds_per_set + n_points as f64 * EVALUATION
    }
}

/// Seconds for the value of an integrand.
const EVALUATION: f64 = 40e-9;

/// The seconds up to which a spectrum may take more work than the trials that it is compared with.
const GENEROUS: f64 = 5.0;

/// How many realizations of `n_points` a spectrum to `lmax` is worth beside `trials` of the
/// measurement, if making a set takes `seconds_per_set`: eight times the work of the trials as long as that is no more
/// than 5 seconds, beyond that 5 seconds or the work of the trials; but no fewer than 300 (or the
/// trials, if these are fewer) and no more than eight times the trials.
///
/// A realization tells more of a variance than a trial does: for a harmonic of degree l it is worth
/// 2l + 1 of them.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of realizations"
)]
pub fn worthwhile_realizations(
    n_points: usize,
    lmax: usize,
    trials: u64,
    seconds_per_set: f64,
) -> u64 {
    let trial = seconds_per_set + n_points as f64 * EVALUATION;
    let realization = seconds_per_set + Method::Auto.seconds(n_points, lmax);
    let work = trials as f64 * trial;
    let balanced = (8.0 * work).min(work.max(GENEROUS)) / realization;
    (balanced as u64).clamp(trials.min(300), trials.saturating_mul(8))
}

#[cfg(test)]
mod tests {
    use super::worthwhile_realizations;

    #[test]
    fn costly_sets_are_not_made_more_often_than_measured() {
        // Cheap: as many as eight times the work allows, here the most.
        assert_eq!(worthwhile_realizations(1024, 4, 1000, 40e-9 * 1024.0), 8000);
        // At 45 ms a set 50 trials take 2.3 s and the spectrum 5 s.
        assert_eq!(worthwhile_realizations(1024, 4, 50, 0.045), 111);
        // At a second a set it takes as long as the trials.
        assert_eq!(worthwhile_realizations(1024, 4, 50, 1.0), 50);
        assert_eq!(worthwhile_realizations(1024, 4, 1000, 1.0), 1000);
        // The floor is that of the trials, and nothing overflows.
        assert_eq!(worthwhile_realizations(usize::MAX, 1 << 40, 1000, f64::INFINITY), 300);
        assert_eq!(worthwhile_realizations(1, 0, u64::MAX, 0.0).min(1), 1);
    }
}
