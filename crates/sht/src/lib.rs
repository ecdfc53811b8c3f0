//! Transforms between scattered points on the sphere and spherical harmonic coefficients.
//!
//! The *adjoint* computes coefficients of weighted points, `a_lm = sum_k w_k conj Y_lm(x_k)`; it is
//! the adjoint of synthesis, not its inverse. [`ExactTransform`] evaluates the definition in
//! O(N lmax^2), to rounding, for any points. [`FastTransform`] computes it to a requested accuracy
//! in O(N log^2(1/epsilon) + lmax^3). [`Transform`] selects one of them. Their Legendre stage is
//! available separately as [`RingTransform`], for functions whose Fourier coefficients are known on
//! rings of constant colatitude; [`DenseRingTransform`] is its adjoint for many more rings than
//! degrees.
//!
//! *Synthesis* evaluates a function with given coefficients at scattered points. *Gradient* also
//! evaluates its tangent gradient, without a singularity at the poles.
//!
//! # Examples
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
//! Synthesis and gradient:
//!
//! ```
//! use glam::DVec3;
//! use sphvar_sht::{FastTransform, FastWorkspace};
//! use sphvar_sh::Alm;
//!
//! // f = z, which is Y_10 sqrt(4 pi/3).
//! let mut alm = Alm::zeros(16)?;
//! alm.column_mut(0)[1] = (4.0 * std::f64::consts::PI / 3.0).sqrt().into();
//! let plan = FastTransform::new(16, 1e-12)?;
//! let points = [DVec3::X, DVec3::Z];
//! let (mut values, mut gradients) = ([0.0; 2], [DVec3::ZERO; 2]);
//! plan.gradient_into(&alm, &points, &mut FastWorkspace::default(), &mut values, &mut gradients);
//! assert!(values[0].abs() < 1e-11 && (values[1] - 1.0).abs() < 1e-11);
//! assert!((gradients[0] - DVec3::Z).length() < 1e-11 && gradients[1].length() < 1e-11);
//! # Ok::<(), sphvar_sht::Error>(())
//! ```
//!
//! [`LeastSquares`] fits coefficients to values at scattered points, and [`QuadratureProblem`] finds
//! quadrature weights of given points, both with a pair of transforms.

mod angles;
mod dense_rings;
mod engine;
mod exact;
mod fast;
mod fit;
mod generators;
mod legendre;
mod normal_equations;
mod quadrature;
mod rings;
mod torus;
mod transform;

pub use dense_rings::{DenseRingTransform, MirroredRings, RingSums};
pub use exact::{ExactTransform, ExactWorkspace};
pub use fast::{FastTransform, FastWorkspace};
pub use fit::{Fit, FitError, FittedEnergy, LeastSquares};
pub use normal_equations::{ConjugateGradients, extreme_eigenvalues};
pub use quadrature::{
    QuadratureError, QuadratureProblem, QuadratureWeights, WeightSigns, exact_degree,
};
pub use rings::{RingTransform, RingWorkspace};
pub use sphvar_sh::Error;
pub use transform::{Method, Transform, TransformWorkspace};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
