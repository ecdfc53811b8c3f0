use std::ops::Range;

use glam::DVec3;
use sphvar_samplers::Progress;

use crate::{Comparison, Error, Experiment, Measurement, Prediction, Trials};

/// The predicted and the measured variance of a [`WarpedPattern`](crate::WarpedPattern), and the
/// values that decide whether the trials saw the tail of f/p.
#[derive(Clone, Debug)]
pub struct WarpedComparison {
    /// Both variances.
    pub comparison: Comparison,
    /// The largest contribution of a point, and the trials in which it occurred.
    pub largest: LargestSeen,
}

/// What is known of the trials of a warped pattern before they are made, as returned by
/// [`WarpedPredictor::experiment`](crate::WarpedPredictor::experiment).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WarpedExperiment {
    pub(super) all: Experiment,
    pub(super) strategy: usize,
    /// The number of points of that strategy.
    pub(super) n_points: usize,
    pub(super) ratio: f64,
    pub(super) direction: [f64; 3],
    pub(super) area: f64,
}

/// The estimates of trials of a warped pattern, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WarpedEstimates {
    /// The estimates of the integral.
    pub estimates: Vec<f64>,
    /// The number of trials that drew a ratio above half of the largest one.
    pub near_largest: u64,
}

impl WarpedEstimates {
    /// Adds the trials that follow.
    pub fn append(&mut self, next: Self) {
        self.estimates.extend(next.estimates);
        self.near_largest += next.near_largest;
    }
}

impl WarpedExperiment {
    /// Returns the comparison of a prediction with the variance of trials, whose estimates `source`
    /// returns: those of consecutive ranges of trials, in their order.
    ///
    /// # Errors
    ///
    /// Returns the errors of `source` and of [`measure_until`](crate::measure_until).
    pub fn measure(
        &self,
        source: &mut dyn FnMut(Range<u64>) -> Result<WarpedEstimates, Error>,
        prediction: Prediction,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<WarpedComparison, Error> {
        let mut near_largest = 0;
        let mut estimates = |range: Range<u64>| {
            let next = source(range)?;
            near_largest += next.near_largest;
            Ok(next.estimates)
        };
        let comparison = self.all.measure(&mut estimates, prediction, trials, progress)?;
        Ok(self.with_largest(comparison, near_largest))
    }

    /// Returns the comparison of a prediction with the variance of estimates.
    #[must_use]
    pub fn comparison(
        &self,
        prediction: Prediction,
        estimates: WarpedEstimates,
    ) -> WarpedComparison {
        let WarpedEstimates { estimates, near_largest } = estimates;
        let comparison = self.all.comparison(prediction, Measurement::new(estimates));
        self.with_largest(comparison, near_largest)
    }

    fn with_largest(&self, comparison: Comparison, trials: u64) -> WarpedComparison {
        let n_trials = comparison.measurement.estimates().len() as f64;
        let chance = (self.area * self.n_points as f64).min(1.0);
        let largest = LargestSeen {
            strategy: self.strategy,
            ratio: self.ratio,
            direction: self.direction.into(),
            expected_trials: chance * n_trials,
            trials,
        };
        WarpedComparison { comparison, largest }
    }
}

/// The largest known ratio `|w f/p|` of an integrand and a density, and the trials that drew one
/// above half of it.
///
/// Where such trials are expected to be few, their number decides about the measured variance. The
/// kurtosis of f/p is large there, so [`Comparison::error`] is, and the measured variance has no
/// interval ([`Comparison::has_too_few_hits`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestSeen {
    /// The strategy whose points contribute most to an estimate, from 0.
    pub strategy: usize,
    /// The largest ratio.
    pub ratio: f64,
    /// Its direction.
    pub direction: DVec3,
    /// The expected number of trials with a ratio above half of it, to a factor of 2 for patterns
    /// with more than one point in that part of the square.
    pub expected_trials: f64,
    /// The number of trials that had one.
    pub trials: u64,
}
