//! Legendre stage: between values on rings and coefficients by degree, one order m at a time.
//!
//! [`Lanes`] holds the rings and [`Order`] the coefficients of the recurrence. [`Adjoint`] and
//! [`Synthesis`] are the two directions of the product with the matrix of Legendre functions.

mod kernel;
mod lanes;
mod order;

pub(crate) use kernel::{Adjoint, Columns, Synthesis};
pub(crate) use lanes::{Lanes, ValueRange};
use order::Anchor;
pub(crate) use order::Order;

/// Number of rings that pass through the recurrence together.
const RINGS: usize = 32;

/// Number of functions that share one pass of the recurrence.
pub(crate) const FUNCTIONS: usize = 4;

/// Numbers per function and ring: real and imaginary part for even l + m, then for odd l + m.
const PARTS: usize = 4;
