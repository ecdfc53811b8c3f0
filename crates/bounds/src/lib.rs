//! Spectral profiles of sampling patterns: closed-form variance bounds and convergence rates.
//!
//! The power spectrum of a pattern of N points often lies between two simple functions, its
//! [`Profile`]s. Substituted for the spectrum, a profile gives the variance of Monte Carlo
//! integration,
//!
//! ```text
//! Var = (4 pi / N) sum_{l >= 1} (2l+1) P_S(l) P_F(l),
//! ```
//!
//! in closed form for whole classes of integrands ([`IntegrandClass`]), with its rate in N, and a
//! bound for a given integrand ([`variance_bound`]). Conversely, a measured spectrum shows
//! whether a profile bounds it and which profile is the tightest bound ([`Bound`]). All functions
//! are pure: they use no randomness and no input or output.
//!
//! Conventions: orthonormal harmonics, white noise has power 1, the frequency axis is
//! `omega = l / sqrt N`, the energy of an integrand is `E(l) = (2l+1) P_F(l)`; the hemisphere is
//! antipodal (the projective plane) and has even degrees only ([`Domain`]).
//!
//! # Examples
//!
//! The variance reduction of a jittered pattern over white noise for an integrand with a jump:
//!
//! ```
//! use sphvar_bounds::{ConvergenceRate, Domain, IntegrandClass, Profile, thesis_bounds};
//!
//! let jump = IntegrandClass::power_law(1.0, 2.0)?;
//! let jittered = thesis_bounds()[2].upper;
//! let white = Profile::constant(1.0)?;
//!
//! assert_eq!(jump.rate(&jittered, Domain::Sphere).to_string(), "N^-1.5");
//! let expected = ConvergenceRate::Algebraic { exponent: -1.0, log: false };
//! assert_eq!(jump.rate(&white, Domain::Sphere), expected);
//! let reduction = jump.variance(&white, 10_000, Domain::Sphere) / jump.variance(&jittered, 10_000, Domain::Sphere);
//! assert!(reduction > 15.0 && reduction < 17.0); // (pi^2 / 6) / (2 / L) with L = 20, nearly
//! # Ok::<(), sphvar_bounds::Error>(())
//! ```

mod bound;
mod branch_and_bound;
mod degree_run;
mod envelope;
mod error;
mod family;
mod fit;
mod integrand_class;
mod measured_spectrum;
mod power_sum;
mod profile;
mod profile_shape;
mod rate;
mod side;
mod thesis_bounds;
mod tightest;
mod variance_range;
mod zeta;

pub use bound::{Bound, BoundVerdict};
pub use error::Error;
pub use family::Family;
pub use integrand_class::{Asymptotic, IntegrandClass};
pub use measured_spectrum::MeasuredSpectrum;
pub use profile::Profile;
pub use profile_shape::ProfileShape;
pub use rate::ConvergenceRate;
pub use side::Side;
pub use sphvar_sh::Domain;
pub use sphvar_spectrum::Spectrum;
pub use thesis_bounds::{ThesisBound, thesis_bounds};
pub use tightest::{Criterion, Offset, Tightest};
pub use variance_range::{VarianceRange, variance_bound};
pub use zeta::{generalized_harmonic, hurwitz_zeta, riemann_zeta, trigamma};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
