//! Spherical harmonics on the unit sphere: associated Legendre functions, coefficients, quadrature.
//!
//! Conventions: `theta` is the colatitude in `[0, pi]`, `phi` the longitude, both in radians;
//! directions are unit `glam::DVec3`. Harmonics are orthonormal, `integral |Y_lm|^2 = 1`, with the
//! Condon-Shortley phase, `Y_lm = lambda_lm(theta) e^(i m phi)`. Coefficients of real functions are
//! stored for `m >= 0` in the layout of [`LmIndex`], `lmax` inclusive.
//!
//! - [`lambda`](lambda()), [`LegendrePlan`], [`Recurrence`]: associated Legendre functions, for one
//!   value, for all values at a colatitude, and for one order at many colatitudes, which are
//!   computed side by side in the registers of the processor. They are accurate at every
//!   colatitude, tested for degrees up to 20000.
//! - [`ylm`], [`real_ylm`] and their `_at` forms for directions: single harmonics.
//! - [`Alm`]: coefficients, energy and power per degree. [`ByParity`]: a value for even and one for
//!   odd degrees.
//! - [`Domain`]: the sphere and the hemisphere. [`Bands`]: the bands of a spectrum, such as their
//!   degrees. [`Frequencies`]: the bands of the unit square. [`TailClasses`]: a value for each class
//!   of bands with a mean power of its own at large radii.
//! - [`legendre_p`]: Legendre polynomials. [`GaussLegendre`]: quadrature on an interval.
//!   [`CompensatedSum`]: sums of many terms.
//!
//! # Examples
//!
//! The coefficients of a sum of point masses, verified by the addition theorem:
//!
//! ```
//! use glam::DVec3;
//! use sphvar_sh::{Alm, legendre_p, ylm_at};
//!
//! let points = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)];
//! let mut alm = Alm::zeros(4)?;
//! for (l, m) in alm.index().iter() {
//!     for p in points {
//!         alm[(l, m)] += ylm_at(l, m as i64, p)?.conj();
//!     }
//! }
//! // sum_m |a_lm|^2 = (2l + 1)/(4 pi) sum over pairs of P_l(p . q)
//! let cos = points[0].dot(points[1]);
//! for (l, energy) in alm.energy_per_degree().into_iter().enumerate() {
//!     let orders = (2 * l + 1) as f64;
//!     let pairs = 2.0 + 2.0 * legendre_p(l, cos)?;
//!     assert!((energy - orders / (4.0 * std::f64::consts::PI) * pairs).abs() < 1e-14);
//! }
//! # Ok::<(), sphvar_sh::Error>(())
//! ```
//!
//! The function of order 500 and degree 1000 on 256 rings, more than 10 times as fast as 256 calls
//! of [`lambda`](lambda()), with the same values:
//!
//! ```
//! use sphvar_sh::{Colatitude, Recurrence, lambda};
//!
//! let rings: Vec<_> = (0..256)
//!     .map(|i| Colatitude::from_theta((f64::from(i) + 0.5) * std::f64::consts::PI / 256.0))
//!     .collect::<Result<_, _>>()?;
//! let mut values = vec![0.0; rings.len()];
//! Recurrence::new(500, 1000).degree_into(1000, &rings, &mut values);
//! assert!(rings.iter().zip(&values).all(|(&ring, &value)| value == lambda(1000, 500, ring)));
//! # Ok::<(), sphvar_sh::Error>(())
//! ```
//!
//! # Features
//!
//! - `serde`: serialization of [`Domain`], [`LmIndex`], [`ByParity`], [`ByAxis`] and [`Frequencies`]
//!   with serde. Off by default.

mod alm;
mod axis;
mod bands;
mod colatitude;
mod compensated_sum;
mod domain;
mod error;
mod frequencies;
mod gauss;
mod index;
mod lambda;
mod lanes;
mod parity;
mod plan;
mod polynomial;
mod recurrence;
mod scaled;
mod sectoral;
mod tail_classes;
mod ylm;

pub use alm::Alm;
pub use axis::ByAxis;
pub use bands::Bands;
pub use colatitude::Colatitude;
pub use compensated_sum::CompensatedSum;
pub use domain::Domain;
pub use error::Error;
pub use frequencies::Frequencies;
pub use gauss::GaussLegendre;
pub use index::{LmIndex, MAX_DEGREE};
pub use lambda::{lambda, lambda_scaled};
pub use parity::ByParity;
pub use plan::LegendrePlan;
pub use polynomial::{legendre_p, legendre_p_into};
pub use recurrence::{Recurrence, Step};
pub use scaled::Scaled;
pub use sectoral::{sectoral, sectoral_function};
pub use tail_classes::TailClasses;
pub use ylm::{real_ylm, real_ylm_at, ylm, ylm_at};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
