//! Transforms between scattered points on the sphere and spherical harmonic coefficients.
//!
//! ```
//! use glam::DVec3;
//! use sphvar_sht::ExactTransform;
//!
//! // Two antipodal unit masses: every odd degree cancels.
//! let transform = ExactTransform::new(8)?;
//! let alm = transform.adjoint(&[DVec3::Z, -DVec3::Z], None)?;
//! let power = alm.power_per_degree();
//! assert!(power[1] == 0.0 && power[3] == 0.0);
//! assert!((power[2] - 1.0 / std::f64::consts::PI).abs() < 1e-14);
//! # Ok::<(), sphvar_sht::Error>(())
//! ```
//!
//! The *adjoint* takes weighted points to coefficients, `a_lm = sum_k w_k conj Y_lm(x_k)`; it is
//! the adjoint of synthesis, not its inverse. [`ExactTransform`] computes it from the definition
//! in O(N lmax^2), to rounding, for any points; [`FastTransform`] to a requested accuracy in
//! O(N log^2(1/epsilon) + lmax^3); [`Transform`] chooses between them. Their Legendre part stands
//! alone as [`RingTransform`], for functions whose Fourier coefficients are known on rings of
//! constant colatitude.

mod angles;
mod cells;
mod engine;
mod exact;
mod fast;
mod generators;
mod legendre;
mod magnitude;
mod polynomial;
mod real;
mod rings;
mod spreading;
mod torus;
mod transform;
mod window;

pub use exact::{ExactTransform, ExactWorkspace};
pub use fast::{FastTransform, FastWorkspace};
pub use rings::{RingTransform, RingWorkspace};
pub use sphvar_sh::Error;
pub use transform::{Method, Transform, TransformWorkspace};
