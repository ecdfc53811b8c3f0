//! Patterns of N directions on the sphere and the hemisphere, and uniform random rotations.
//!
//! ```
//! use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
//!
//! // One direction in each of 48 equal-area cells, the whole set turned uniformly.
//! let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
//! let ensemble = Realizations::rotated(&*jittered, Streams::new(0, Purpose::Pattern, 48));
//! let points = ensemble.realize(0)?;
//! assert_eq!(points.len(), 48);
//! assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
//! # Ok::<(), sphvar_samplers::Error>(())
//! ```
//!
//! A [`Sampler`] makes one realization from a random generator; [`Streams`] give every
//! realization a generator of its own, so that results do not depend on threads or order;
//! [`Realizations`] put the two together and turn each set by a [`uniform_rotation`].
//! [`Pattern`] is the list of what can be built by name, with the numbers of points that exist.

mod archimedes;
mod ccvt;
mod domain;
mod error;
mod fibonacci;
mod healpix;
mod pattern;
mod realizations;
mod rotation;
mod sampler;
mod streams;
mod white_noise;

pub use ccvt::{Ccvt, MassPoints, Tessellation};
pub use domain::Domain;
pub use error::Error;
pub use fibonacci::Fibonacci;
pub use healpix::{HealpixJittered, HealpixRegular};
pub use pattern::Pattern;
pub use realizations::Realizations;
pub use rotation::{rotate, uniform_rotation};
pub use sampler::Sampler;
pub use streams::{Purpose, Streams};
pub use white_noise::WhiteNoise;
