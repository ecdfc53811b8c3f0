//! Patterns of N directions on the sphere and the hemisphere and of N points of the unit square, with
//! uniform random rotations and shifts.
//!
//! The near half of a set of 192 points of eight patterns, and their mean power at the degrees 1 to
//! 42, relative to white noise (dashed):
//!
#![doc = include_str!("../images/patterns.svg")]
//!
//! ```
//! use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
//!
//! // One direction in each of 48 equal-area cells, the whole set rotated uniformly.
//! let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
//! let ensemble = Realizations::rotated(&*jittered, Streams::new(0, Purpose::Pattern, 48));
//! let points = ensemble.realize(0)?;
//! assert_eq!(points.len(), 48);
//! assert!(points.points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
//! # Ok::<(), sphvar_samplers::Error>(())
//! ```
//!
//! A [`Sampler`] generates one realization from a random generator. [`Streams`] provide a separate
//! generator for every realization, so that results do not depend on threads or order.
//! [`Realizations`] combine the two and rotate each set by a [`uniform_rotation`].
//! [`SpectralControl`] generates patterns with a prescribed power at every degree. [`Pattern`]
//! lists the patterns that can be built by name, with their valid numbers of points.
//!
//! The unit square, a torus, has the same items of its own: [`SquareSampler`], [`SquarePattern`] and
//! [`SquareRealizations`], which shift each set by a [`uniform_shift`] modulo 1. [`OnSphere`] and
//! [`CosineHemisphere`] map its points to directions; [`checks`] tests strata, nets and lattices.
//!
//! ```
//! use sphvar_samplers::{Purpose, SquarePattern, SquareRealizations, Streams, toroidal_separation};
//!
//! // A Fibonacci lattice, shifted: its separation is 1/sqrt(N) for N = 5, 13, 34, 89, ...
//! let lattice = SquarePattern::FibonacciLattice.build(89)?;
//! let ensemble = SquareRealizations::shifted(&*lattice, Streams::new(0, Purpose::Pattern, 89));
//! let distance = toroidal_separation(&ensemble.realize(0)?.points, &())?.unwrap();
//! assert!((distance - 1.0 / 89_f64.sqrt()).abs() < 1e-14);
//! # Ok::<(), sphvar_samplers::Error>(())
//! ```
//!
//! # Features
//!
//! - `serde`: serialization of [`Domain`] with serde. Off by default.

mod count;
mod cube_layers;
mod definition;
mod disks;
mod ensemble;
mod error;
mod facts;
mod family;
mod fn_pattern;
mod hash;
mod of_pattern;
mod optimization;
mod pattern;
mod pattern_list;
mod patterns;
mod rotations;
mod rule;
mod sampler;
mod search;
mod set_distribution;
mod space;
mod square;
mod tessellation;
mod valid_counts;
mod vector;

pub use cube_layers::CellWeights;
pub use definition::{FileResolver, ProfileTable};
pub(crate) use ensemble::PointFiles;
pub use ensemble::{
    Ensemble, PointFile, PointSet, PointSets, Progress, Purpose, Realizations, SECONDS_PER_WORK,
    Share, Stopped, Streams, rotate, uniform_rotation,
};
pub use error::Error;
pub use facts::{CostOrder, PatternFacts, Rate};
pub use family::SamplerFamily;
pub use fn_pattern::FnPattern;
pub use optimization::{
    NoiseColour, PowerProfile, SinglePeak, SpectralControl, SpectralTarget, SquareSpectralControl,
    covering_radius, riesz_energy,
};
pub use patterns::*;
pub use rotations::*;
pub use rule::Rule;
pub use sampler::Sampler;
pub use search::{separation, toroidal_separation};
pub use set_distribution::{SetDistribution, Strata};
pub use space::{Point, Space, Square};
pub use sphvar_grammar as grammar;
pub use sphvar_sh::Domain;
pub use square::*;
pub use tessellation::Tessellation;
pub use valid_counts::ValidCounts;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
