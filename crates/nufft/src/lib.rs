//! Nonuniform Fourier transform of scattered points on the torus, in two dimensions and to a
//! requested accuracy.
//!
//! ```
//! use sphvar_nufft::TorusTransform;
//!
//! // A point of weight 2 a quarter of a turn along the second coordinate.
//! let transform = TorusTransform::new(8, 1e-10)?;
//! let c = transform.adjoint(&[[0.0, 0.25]], Some(&[2.0]))?;
//! // exp(-2 pi i/4) = -i.
//! let at_one = c.get(0, 1).unwrap();
//! assert!(at_one.re.abs() < 1e-9 && (at_one.im + 2.0).abs() < 1e-9);
//! # Ok::<(), sphvar_nufft::Error>(())
//! ```
//!
//! [`TorusTransform`] takes weighted points to Fourier coefficients in O(N log^2(1/epsilon) +
//! kmax^2 log kmax); [`direct_adjoint`] is its definition. Points are spread onto a regular grid by
//! a window, the grid is Fourier transformed, and the coefficients are divided by the transform of
//! the window.
//!
//! [`parts`] has the stages up to the grid, for transforms that continue differently; that of the
//! sphere does.

mod cells;
mod coefficients;
mod design;
mod direct;
mod error;
mod fourier;
mod input;
mod limits;
mod long_sum;
mod magnitude;
mod memory;
mod polynomial;
mod real;
mod sizes;
mod spreading;
mod transform;
mod window;

pub use coefficients::TorusCoefficients;
pub use direct::direct_adjoint;
pub use error::Error;
pub use limits::{MAX_EPSILON, MAX_KMAX, MIN_EPSILON};
pub use transform::{TorusTransform, TorusWorkspace};

/// The stages between points and grid, and the arithmetic that they share with what follows.
pub mod parts {
    pub use crate::cells::{Cells, LANES, Places, Turns};
    pub use crate::design::Design;
    pub use crate::long_sum::{SHORT, add_with_rests};
    pub use crate::magnitude::magnitude;
    pub use crate::polynomial::interpolate;
    pub use crate::real::Real;
    pub use crate::sizes::good_size;
    pub use crate::spreading::Spreading;
    pub use crate::window::Window;
}
