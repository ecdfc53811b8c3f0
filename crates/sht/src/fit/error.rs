use sphvar_sh::Error;

use super::LeastSquares;
use crate::normal_equations::SolveError;

/// The reason why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// There are no points.
    #[error("a fit needs at least 1 point, got 0")]
    NoPoints,
    /// The numbers of points and of values or weights differ.
    #[error("{n_points} points need as many {what}, got {got}")]
    Lengths {
        /// `values` or `weights`.
        what: &'static str,
        /// The number of points.
        n_points: usize,
        /// The number of values or weights.
        got: usize,
    },
    /// A value is not finite.
    #[error("value {index} (0-based) must be finite, got {value}")]
    Value {
        /// Its index.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The squares of the values, of which variances and energies are sums, overflow or underflow.
    #[error(
        "the largest absolute value must be 0 or from {:e} to {:e}, got {got:e}; scale the values",
        LeastSquares::MAGNITUDES[0],
        LeastSquares::MAGNITUDES[1]
    )]
    Magnitude {
        /// The largest absolute value.
        got: f64,
    },
    /// A weight is negative or not finite.
    #[error("weight {index} (0-based) of a fit must be finite and at least 0, got {weight}")]
    Weight {
        /// Its index.
        index: usize,
        /// The weight.
        weight: f64,
    },
    /// All weights are 0.
    #[error("all weights are 0; a fit needs a positive one")]
    NoWeight,
    /// The ridge is invalid.
    #[error("the ridge must be finite and at least 0, got {got}")]
    Ridge {
        /// The ridge.
        got: f64,
    },
    /// There are more harmonics than distinct points.
    #[error(
        "a fit to degree {lmax} needs {n_harmonics} distinct points, one for each harmonic, got {n_distinct}; the largest possible degree is {largest}"
    )]
    TooFewPoints {
        /// The requested degree.
        lmax: usize,
        /// The number of harmonics up to this degree.
        n_harmonics: usize,
        /// The number of distinct points of positive weight.
        n_distinct: usize,
        /// The largest degree that this number of points permits.
        largest: usize,
    },
    /// The points do not determine the coefficients.
    #[error(
        "the points do not determine a fit to degree {lmax}: its condition number is at least {condition:.1e} after {iterations} iterations; use a lower degree, or a ridge of about {ridge:.1e}, which draws undetermined coefficients to 0"
    )]
    IllConditioned {
        /// The requested degree.
        lmax: usize,
        /// The estimated condition number.
        condition: f64,
        /// The number of iterations.
        iterations: usize,
        /// A ridge that limits the condition number to about 30.
        ridge: f64,
    },
    /// The caller stopped the work.
    #[error("stopped")]
    Stopped,
    /// A transform is unavailable.
    #[error(transparent)]
    Transform(#[from] Error),
}

impl From<SolveError> for FitError {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::Stopped => Self::Stopped,
            SolveError::Memory(error) => Self::Transform(error),
        }
    }
}
