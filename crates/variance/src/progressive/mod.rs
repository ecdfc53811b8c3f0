//! Errors of every prefix of a sequence.

mod chord_kernel;
mod estimate;
mod factors;
mod low_degrees;
mod measurement;
mod predictor;
mod prefix;
mod prefixes;
mod space;
mod sphere_variances;
mod square_variances;
mod warped;
mod whole_sets;

pub use factors::Factors;
pub use measurement::PrefixMeasurement;
pub use predictor::ProgressivePredictor;
pub use space::{PrefixVariances, ProgressiveSpace};

use crate::{PredictedVariance, Prediction};

/// How the sets of a sequence are randomized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Randomized {
    /// By a uniform rotation of each set, on the square by a uniform shift modulo 1, so that
    /// variances are predicted.
    Rotated,
    /// By the sequence alone, such as its scrambling. Variances are measured, but predicted only for
    /// independent points.
    AsDrawn,
}

/// The variance of the estimate from the first points of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgressivePoint {
    /// The number of points N.
    pub n_points: usize,
    /// The predicted variance; [`Prediction::UNKNOWN`] for sets that are not homogeneous.
    pub prediction: Prediction,
    /// The measured variance, if there were trials.
    pub measurement: Option<PrefixMeasurement>,
}

impl PredictedVariance for ProgressivePoint {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn prediction(&self) -> &Prediction {
        &self.prediction
    }
}

/// The variances of the prefixes of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgressiveCurve {
    /// The variances in increasing order of their distinct numbers of points.
    pub points: Vec<ProgressivePoint>,
    /// The number of realizations behind the predictions: 1 for a sequence that is not random, 0 if
    /// they are in closed form or unknown.
    pub realizations: u64,
}
