use thiserror::Error as ThisError;

/// Error for an invalid argument or a failed allocation.
#[derive(Debug, Clone, Copy, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// The maximum degree exceeds the supported limit.
    #[error("degree {lmax} is too large: the largest supported degree is {max}")]
    DegreeTooLarge {
        /// The requested degree.
        lmax: usize,
        /// The maximum supported degree.
        max: usize,
    },
    /// The maximum frequency of the bands of the square is out of range.
    #[error("maximum frequency {kmax} is out of range: {min} to {max} are supported")]
    Frequency {
        /// The requested maximum frequency.
        kmax: usize,
        /// The minimum supported value.
        min: usize,
        /// The maximum supported value.
        max: usize,
    },
    /// The requested accuracy of a transform is NaN or out of range.
    #[error("epsilon must be in [{min:e}, {max:e}], got {epsilon}")]
    Accuracy {
        /// The value given.
        epsilon: f64,
        /// The minimum epsilon.
        min: f64,
        /// The maximum epsilon.
        max: f64,
    },
    /// Allocation of a table failed.
    #[error("no memory for {len} values of {bytes_each} bytes each: choose a smaller lmax")]
    OutOfMemory {
        /// The number of values.
        len: usize,
        /// The size of one value in bytes.
        bytes_each: usize,
    },
    /// The number of coefficients does not match the maximum degree.
    #[error("{got} coefficients given, but lmax = {lmax} requires {expected}")]
    CoefficientCount {
        /// The maximum degree.
        lmax: usize,
        /// The required number.
        expected: usize,
        /// The number given.
        got: usize,
    },
    /// The colatitude is NaN or outside `[0, pi]`.
    #[error("colatitude {theta} is not in [0, pi] (radians)")]
    Colatitude {
        /// The value given, in radians.
        theta: f64,
    },
    /// The longitude or its product with the order is not finite.
    #[error("longitude {phi} is not usable: m * phi must be finite (radians)")]
    Longitude {
        /// The value given, in radians.
        phi: f64,
    },
    /// The direction has a non-finite component or is not a unit vector.
    #[error("direction ({x}, {y}, {z}) is not a unit vector")]
    Direction {
        /// The first component.
        x: f64,
        /// The second component.
        y: f64,
        /// The third component.
        z: f64,
    },
    /// The order is invalid for the degree.
    #[error("order m = {m} does not belong to degree l = {l}: -l <= m <= l is required")]
    Order {
        /// The degree.
        l: usize,
        /// The order.
        m: i64,
    },
    /// The argument of a Legendre polynomial is NaN or outside `[-1, 1]`.
    #[error("argument x = {x} of the Legendre polynomial is not in [-1, 1]")]
    Argument {
        /// The value given.
        x: f64,
    },
    /// The number of quadrature nodes is zero or too large.
    #[error("{n} quadrature nodes requested: 1 to {max} are supported")]
    NodeCount {
        /// The requested number.
        n: usize,
        /// The maximum supported number.
        max: usize,
    },
}
