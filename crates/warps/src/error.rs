use std::error::Error as StdError;
use std::fmt;

/// The reason why a map cannot be built.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its valid values in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
    /// A density map has no texels.
    Shape {
        /// The number of columns.
        width: usize,
        /// The number of rows.
        height: usize,
    },
    /// The number of texels is not width times height.
    TexelCount {
        /// The number of columns.
        width: usize,
        /// The number of rows.
        height: usize,
        /// The number given.
        got: usize,
    },
    /// A texel is negative, infinite or NaN.
    Texel {
        /// Its row, counted from 0.
        row: usize,
        /// Its column, counted from 0.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// A density map is 0 on its whole domain.
    NoDensity {
        /// The domain in words.
        domain: &'static str,
    },
    /// A triangle or rectangle does not have a solid angle that can be sampled.
    Degenerate {
        /// The shape in words.
        shape: &'static str,
        /// The requirement in words.
        requirement: &'static str,
    },
    /// Allocation of a table failed.
    OutOfMemory {
        /// The number of values.
        len: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter { name, range, got } => write!(f, "{name} must be {range}, got {got}"),
            Self::Shape { width, height } => {
                write!(f, "a density map needs at least one texel, got {width} x {height}")
            }
            Self::TexelCount { width, height, got } => {
                write!(f, "{got} texels given, but {width} x {height} are required")
            }
            Self::Texel { row, column, value } => write!(
                f,
                "the density must be finite and not negative, but texel (row {row}, column {column}; \
                 0-based) is {value}"
            ),
            Self::NoDensity { domain } => {
                write!(f, "the density is 0 on {domain}; at least one texel must be positive there")
            }
            Self::Degenerate { shape, requirement } => write!(f, "{shape} must have {requirement}"),
            Self::OutOfMemory { len } => {
                write!(f, "no memory for {len} values of 8 bytes each: use a smaller map")
            }
        }
    }
}

impl StdError for Error {}
