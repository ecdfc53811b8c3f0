use thiserror::Error as ThisError;

use crate::limits::{MAX_EPSILON, MAX_KMAX, MIN_EPSILON};

/// What can be wrong with the input of this crate.
#[derive(Debug, Clone, Copy, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// The requested accuracy is NaN or outside its range.
    #[error("epsilon must be in [{MIN_EPSILON:e}, {MAX_EPSILON:e}], got {epsilon}")]
    Accuracy {
        /// The value given.
        epsilon: f64,
    },
    /// The largest frequency exceeds what the crate supports.
    #[error("kmax = {kmax} is too large: the largest supported frequency is {MAX_KMAX}")]
    FrequencyTooLarge {
        /// The value given.
        kmax: usize,
    },
    /// The numbers of weights and points differ.
    #[error("{weights} weights given for {points} points: one weight per point is required")]
    WeightCount {
        /// The number of weights.
        weights: usize,
        /// The number of points.
        points: usize,
    },
    /// There are more points than can be numbered.
    #[error("{points} points are too many for one transform: at most {max} are supported")]
    TooManyPoints {
        /// The number of points.
        points: usize,
        /// The largest number supported.
        max: u32,
    },
    /// A coordinate is NaN or outside `[0, 1)`.
    #[error("point {index} (0-based) is ({u}, {v}): both coordinates must be in [0, 1), in turns")]
    Point {
        /// The number of the point, from 0.
        index: usize,
        /// The first coordinate.
        u: f64,
        /// The second coordinate.
        v: f64,
    },
    /// A weight is not finite.
    #[error("weight {index} (0-based) is {weight}: weights must be finite")]
    Weight {
        /// The number of the point, from 0.
        index: usize,
        /// The weight.
        weight: f64,
    },
    /// A sum of weights exceeds the range of f64.
    #[error("the sum of the absolute weights exceeds the largest number: scale the weights down")]
    Overflow,
    /// Coefficients of another largest frequency were passed as output.
    #[error("the output holds frequencies up to {got}, the transform is for {expected}")]
    OutputSize {
        /// The largest frequency of the transform.
        expected: usize,
        /// That of the output.
        got: usize,
    },
    /// Memory for grids or coefficients is unavailable.
    #[error(
        "no memory for {len} values of {bytes_each} bytes each: choose a smaller kmax or fewer points"
    )]
    OutOfMemory {
        /// The number of values.
        len: usize,
        /// The size of one value in bytes.
        bytes_each: usize,
    },
}
