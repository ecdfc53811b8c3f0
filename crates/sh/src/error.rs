use thiserror::Error as ThisError;

/// What can be wrong with the input of this crate.
#[derive(Debug, Clone, Copy, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// The largest degree asked for exceeds what the crate supports.
    #[error("degree {lmax} is too large: the largest supported degree is {max}")]
    DegreeTooLarge {
        /// The degree asked for.
        lmax: usize,
        /// The largest degree supported.
        max: usize,
    },
    /// The accuracy requested of a transform is NaN or outside its range.
    #[error("epsilon must be in [{min:e}, {max:e}], got {epsilon}")]
    Accuracy {
        /// The value given.
        epsilon: f64,
        /// The least accuracy that can be kept.
        min: f64,
        /// The largest.
        max: f64,
    },
    /// The memory for a table could not be had.
    #[error("no memory for {len} values of {bytes_each} bytes each: choose a smaller lmax")]
    OutOfMemory {
        /// Number of values asked for.
        len: usize,
        /// Size of one value in bytes.
        bytes_each: usize,
    },
    /// A list of coefficients does not have the length its degree calls for.
    #[error("{got} coefficients given, lmax = {lmax} needs {expected}")]
    CoefficientCount {
        /// The largest degree.
        lmax: usize,
        /// Length that belongs to `lmax`.
        expected: usize,
        /// Length given.
        got: usize,
    },
    /// The colatitude is NaN or outside `[0, pi]`.
    #[error("colatitude {theta} is not in [0, pi] (radians)")]
    Colatitude {
        /// The value given, radians.
        theta: f64,
    },
    /// The longitude is not finite, or its multiple by the order is not.
    #[error("longitude {phi} is not usable: m * phi must be finite (radians)")]
    Longitude {
        /// The value given, radians.
        phi: f64,
    },
    /// The direction has a component that is not finite, or is not a unit vector.
    #[error("direction ({x}, {y}, {z}) is not a unit vector")]
    Direction {
        /// First component.
        x: f64,
        /// Second component.
        y: f64,
        /// Third component.
        z: f64,
    },
    /// The order does not belong to the degree.
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
    #[error("{n} quadrature nodes asked for: 1 to {max} are possible")]
    NodeCount {
        /// The number asked for.
        n: usize,
        /// The largest number supported.
        max: usize,
    },
}
