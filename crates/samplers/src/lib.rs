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
//! assert!(points.points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
//! # Ok::<(), sphvar_samplers::Error>(())
//! ```
//!
//! A [`Sampler`] makes one realization from a random generator; [`Streams`] give every
//! realization a generator of its own, so that results do not depend on threads or order;
//! [`Realizations`] put the two together and turn each set by a [`uniform_rotation`].
//! [`SpectralControl`] makes patterns whose power is chosen, degree by degree.
//! [`Pattern`] is the list of what can be built by name, with the numbers of points that exist.

mod best_candidate;
mod ccvt;
mod cosine_hemisphere;
mod count;
mod cube_grid;
mod descent;
mod equal_area;
mod error;
mod family;
mod fibonacci;
mod grid;
mod halton;
mod hammersley;
mod hash;
mod healpix;
mod jittered_square;
mod law;
mod lloyd;
mod of_pattern;
mod on_sphere;
mod pattern;
mod pattern_facts;
mod point_set;
mod point_sets;
mod poisson_disk;
mod progress;
mod radical_inverse;
mod realizations;
mod region;
mod riesz;
mod riesz_energy;
mod rotation;
mod sampler;
mod sobol;
mod spectral_control;
mod spiral;
mod square_pattern;
mod streams;
mod voronoi;
mod white_noise;
mod white_square;

pub use best_candidate::BestCandidate;
pub use ccvt::{Ccvt, MassPoints, Tessellation};
pub use cosine_hemisphere::CosineHemisphere;
pub use equal_area::{EqualArea, Placement};
pub use error::Error;
pub use family::SamplerFamily;
pub use fibonacci::Fibonacci;
pub use halton::Halton;
pub use hammersley::Hammersley;
pub use healpix::{HealpixJittered, HealpixRegular};
pub use jittered_square::JitteredSquare;
pub use law::{Law, Strata};
pub use lloyd::{Lloyd, quantization_energy};
pub use on_sphere::OnSphere;
pub use pattern::Pattern;
pub use pattern_facts::PatternFacts;
pub use point_set::PointSet;
pub use point_sets::PointSets;
pub use poisson_disk::{DiskMode, PoissonDisk};
pub use progress::{Progress, SECONDS_PER_WORK, Share, Stopped};
pub use realizations::{Ensemble, Realizations};
pub use region::Region;
pub use riesz::Riesz;
pub use riesz_energy::riesz_energy;
pub use rotation::{rotate, uniform_rotation};
pub use sampler::Sampler;
pub use sobol::Sobol;
pub use spectral_control::{PowerProfile, SpectralControl, SpectralTarget};
pub use sphvar_sh::Domain;
pub use spiral::GeneralizedSpiral;
pub use square_pattern::SquarePattern;
pub use streams::{Purpose, Streams};
pub use white_noise::WhiteNoise;
pub use white_square::WhiteSquare;
