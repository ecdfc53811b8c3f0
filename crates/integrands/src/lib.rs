//! Integrands on the sphere, the hemisphere and the unit square: values, exact integrals, harmonic
//! coefficients and energy per degree or frequency.
//!
//! ```
//! use sphvar_integrands::{Cap, Domain, Integrand};
//!
//! // The indicator of the cap of 60 degrees around the north pole.
//! let cap = Cap::from_degrees(60.0)?;
//! assert!((cap.exact(Domain::Sphere).unwrap() - std::f64::consts::PI).abs() < 1e-15);
//! let energy = cap.energy(Domain::Sphere, 100)?;
//! // Energies of functions with jumps fall as l^-2; the total beyond degree 100 is known.
//! assert!(energy.beyond(100) < 0.01 * energy.total());
//! # Ok::<(), sphvar_integrands::Error>(())
//! ```
//!
//! An [`Integrand`] is a function of direction with, where known, its exact integral and its
//! [`Energy`] per degree. Closures are integrands that can be measured but not predicted;
//! [`AdaptiveFunction`] finds their degree and energies, with errors, and [`SampledFunction`] takes
//! a degree or a [`Shape`] with edges, which gives integral and energies to rounding. Closed forms
//! replace quadrature where they are available.
//!
//! A [`SquareIntegrand`] is a function on the unit square with its energy per pair of frequencies, off
//! and on the axes; [`AdaptiveSquareFunction`] finds it for closures, and [`SquareExpression`] reads
//! named ones, such as `zone-plate * disk:radius=0.3`.

mod coefficients;
mod definition;
mod energy;
mod energy_errors;
mod error;
mod expression;
mod functions;
mod integrand;
mod named_terms;
mod projection;
mod quadrature;
mod shape;
mod square;
mod term;
mod vector_integrand;
mod visible_half_integrand;
mod warps;

pub use coefficients::Coefficients;
pub use definition::{IntegrandResolver, NoFiles};
pub use energy::Energy;
pub use energy_errors::EnergyErrors;
pub use error::Error;
pub use expression::{Expression, Factor, Summand};
pub use functions::*;
pub use integrand::Integrand;
pub use projection::{HarmonicProjection, Irradiance, ProjectedCoefficient};
pub use shape::{Circle, Shape};
pub use sphvar_grammar as grammar;
pub use sphvar_sh::Domain;
pub use square::*;
pub use vector_integrand::VectorIntegrand;
pub use visible_half_integrand::{VisibleHalfEstimator, VisibleHalfIntegrand};
pub use warps::*;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
