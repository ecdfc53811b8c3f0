use glam::DVec3;

use crate::Comparison;

/// The predicted and the measured variance of a [`WarpedPattern`](crate::WarpedPattern), and the
/// values that decide whether the trials saw the tail of f/p.
#[derive(Clone, Debug)]
pub struct WarpedComparison {
    /// Both variances.
    pub comparison: Comparison,
    /// The largest contribution of a point, and the trials in which it occurred.
    pub largest: LargestSeen,
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
