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

use sphvar_samplers::Progress;

use self::measurement::measured_points;
use crate::{Error, Experiment, PredictedVariance, Prediction};

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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProgressivePoint {
    /// The number of points N.
    pub n_points: usize,
    /// The predicted variance; [`Prediction::UNKNOWN`] for sets that are not homogeneous.
    pub prediction: Prediction,
    /// The measured variance, if there were trials.
    pub measurement: Option<PrefixMeasurement>,
}

impl ProgressiveCurve {
    /// Returns the curve with the variances of
    /// [`ProgressivePredictor::estimates`], bit-identical to [`ProgressivePredictor::measure`] for
    /// all trials in their order. `experiments` are those of
    /// [`ProgressivePredictor::experiments`].
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless every point has an experiment and as many estimates, at
    /// least one, as the others, and an error if `progress` stops the work.
    pub fn measured(
        &self,
        experiments: &[Experiment],
        estimates: &[f64],
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let n_points = self.points.len();
        let are_all = !estimates.is_empty() && estimates.len().is_multiple_of(n_points);
        if experiments.len() != n_points || !are_all {
            let (name, got) = ("number of estimates", estimates.len() as f64);
            let range = "a multiple of the number of prefixes, each with its experiment";
            return Err(Error::Parameter { name, range, got });
        }
        let points = measured_points(&self.points, estimates, experiments, randomized, progress)?;
        Ok(Self { points, realizations: self.realizations })
    }
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProgressiveCurve {
    /// The variances in increasing order of their distinct numbers of points.
    pub points: Vec<ProgressivePoint>,
    /// The number of realizations behind the predictions: 1 for a sequence that is not random, 0 if
    /// they are in closed form or unknown.
    pub realizations: u64,
}
