//! Nonuniform Fourier transforms of scattered points on the torus, in two dimensions and to a
//! requested accuracy.
//!
//! [`TorusTransform`] computes the Fourier coefficients of weighted points (type 1) and the values
//! and derivatives of a Fourier series at points (type 2), with O(N log^2(1/epsilon) + kmax^2 log
//! kmax) operations. [`CircleTransform`] is type 1 in one dimension, to much higher frequencies.
//! [`direct_adjoint`], [`direct_evaluate`] and others evaluate the definitions.
//!
//! Type 1 spreads the points onto a regular grid with a window, applies a Fourier transform, and
//! divides the coefficients by the transform of the window. Type 2 takes the same steps in reverse.
//!
//! [`parts`] exports the stages between points and grid, for use in other transforms such as that
//! of the sphere.
//!
//! # Examples
//!
//! ```
//! use sphvar_nufft::TorusTransform;
//!
//! // A point of weight 2 a quarter of a turn along the second coordinate.
//! let transform = TorusTransform::new(8, 1e-10)?;
//! let c = transform.adjoint(&[[0.0, 0.25_f64]], Some(&[2.0]))?;
//! // exp(-2 pi i/4) = -i.
//! let at_one = c.get(0, 1).unwrap();
//! assert!(at_one.re.abs() < 1e-9 && (at_one.im + 2.0).abs() < 1e-9);
//! # Ok::<(), sphvar_nufft::Error>(())
//! ```

mod cells;
mod circle;
mod coefficients;
mod design;
mod direct;
mod direct_evaluate;
mod engine;
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
mod threads;
mod transform;
mod window;

pub use circle::{CircleTransform, CircleWorkspace};
pub use coefficients::{ComplexTorusCoefficients, TorusCoefficients};
pub use direct::{direct_adjoint, direct_adjoint_complex, direct_circle};
pub use direct_evaluate::{direct_evaluate, direct_evaluate_complex, direct_gradient};
pub use error::Error;
pub use limits::{MAX_CIRCLE_KMAX, MAX_EPSILON, MAX_KMAX, MIN_EPSILON};
pub use real::Real;
pub use transform::{TorusTransform, TorusWorkspace};

/// The stages between points and grid, and the arithmetic shared with later stages.
pub mod parts {
    pub use crate::cells::{Cells, LANES, Places, Turns};
    pub use crate::design::Design;
    pub use crate::long_sum::{SHORT, add_with_rests};
    pub use crate::magnitude::{magnitude, magnitude_of, magnitude_of_complex, sum_of_sizes};
    pub use crate::memory::resize;
    pub use crate::polynomial::interpolate;
    pub use crate::real::Real;
    pub use crate::sizes::good_size;
    pub use crate::spreading::Spreading;
    pub use crate::threads::{Threads, share, zip_all};
    pub use crate::window::{Window, WindowTable};
    pub use rustfft::{Fft, FftDirection};
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
