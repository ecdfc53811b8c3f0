use thiserror::Error as ThisError;

use crate::limits::{MAX_EPSILON, MIN_EPSILON};

/// Error of a transform on the torus.
#[derive(Debug, Clone, Copy, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// The requested accuracy is NaN or out of range.
    #[error("epsilon must be in [{MIN_EPSILON:e}, {MAX_EPSILON:e}], got {epsilon}")]
    Accuracy {
        /// The value given.
        epsilon: f64,
    },
    /// The maximum frequency exceeds the supported limit.
    #[error("kmax = {kmax} is too large: the largest supported frequency is {max}")]
    FrequencyTooLarge {
        /// The value given.
        kmax: usize,
        /// The largest supported value.
        max: usize,
    },
    /// The numbers of weights and points differ.
    #[error("{weights} weights given for {points} points: one weight per point is required")]
    WeightCount {
        /// The number of weights.
        weights: usize,
        /// The number of points.
        points: usize,
    },
    /// The number of points exceeds the supported limit.
    #[error("{points} points are too many for one transform: at most {max} are supported")]
    TooManyPoints {
        /// The number of points.
        points: usize,
        /// The maximum supported number.
        max: u32,
    },
    /// A coordinate is NaN or outside `[0, 1)`.
    #[error("point {index} (0-based) is ({u}, {v}): both coordinates must be in [0, 1), in turns")]
    Point {
        /// The index of the point, 0-based.
        index: usize,
        /// The first coordinate.
        u: f64,
        /// The second coordinate.
        v: f64,
    },
    /// A coordinate on the circle is NaN or outside `[0, 1)`.
    #[error("coordinate {index} (0-based) is {u}: it must be in [0, 1), in turns")]
    Coordinate {
        /// The index of the point, 0-based.
        index: usize,
        /// The coordinate.
        u: f64,
    },
    /// A weight is not finite.
    #[error("weight {index} (0-based) is {weight}: weights must be finite")]
    Weight {
        /// The index of the point, 0-based.
        index: usize,
        /// The weight.
        weight: f64,
    },
    /// A coefficient is not finite.
    #[error("coefficient {index} (0-based) is {value}: coefficients must be finite")]
    Coefficient {
        /// The index in the order of the stored values, 0-based.
        index: usize,
        /// The real or imaginary part that is not finite.
        value: f64,
    },
    /// The sum of the absolute weights or coefficients overflows the number type.
    #[error(
        "the sum of the absolute weights or coefficients exceeds the largest number: scale them down"
    )]
    Overflow,
    /// Coefficients have a maximum frequency other than that of the transform.
    #[error("the coefficients have kmax = {got}, the transform has kmax = {expected}")]
    KmaxMismatch {
        /// The maximum frequency of the transform.
        expected: usize,
        /// The maximum frequency of the coefficients.
        got: usize,
    },
    /// The numbers of values and points differ.
    #[error("memory for {got} values given: {expected} are required")]
    ValueCount {
        /// The number of values that the points have.
        expected: usize,
        /// The number of values that the memory holds.
        got: usize,
    },
    /// The numbers of weight vectors and outputs differ.
    #[error(
        "{inputs} weight vectors given for {outputs} outputs: one output per vector is required"
    )]
    BatchSize {
        /// The number of weight vectors.
        inputs: usize,
        /// The number of outputs.
        outputs: usize,
    },
    /// Allocation of grids or coefficients failed.
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
