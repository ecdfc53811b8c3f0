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
