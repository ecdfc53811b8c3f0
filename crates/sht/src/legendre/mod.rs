//! The Legendre stage: one order m at a time, between values on rings and coefficients by degree.
//!
//! [`Lanes`] holds the rings, [`Order`] the coefficients of the recurrence, [`Adjoint`] and
//! [`Synthesis`] are the two directions of the product with the matrix of Legendre functions.

mod kernel;
mod lanes;
mod order;

pub(crate) use kernel::{Adjoint, Columns, Synthesis};
pub(crate) use lanes::{Lanes, ValueRange};
use order::Anchor;
pub(crate) use order::Order;

/// Rings that are taken through the recurrence together.
const RINGS: usize = 32;

/// Functions that share one pass of the recurrence.
pub(crate) const FUNCTIONS: usize = 4;

/// Numbers of one function on one ring: real and imaginary part for even l + m, then for odd.
const PARTS: usize = 4;
