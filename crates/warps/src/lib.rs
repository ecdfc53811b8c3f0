//! Maps from the unit square to the disk, the sphere and the hemisphere that preserve areas or have
//! a known density.
//!
//! A [`Warp`] is a map with its density and its inverse. Importance sampling by points of the
//! square is uniform sampling of the pulled-back integrand f(T(u))/p(T(u)).
//!
//! | map | density | round trips | ns |
//! |---|---|---|---|
//! | [`UniformCap`] | uniform on sphere, hemisphere or a cap (Archimedes) | 2e-15 | 15 |
//! | [`OctahedralSphere`] | uniform on the sphere (Clarberg) | 1e-15 | 17 |
//! | [`ConcentricDisk`] | uniform on the unit disk (Shirley and Chiu) | 1e-15 | 15 |
//! | [`ConcentricHemisphere`] | uniform on the hemisphere (Shirley and Chiu, Clarberg) | 1e-15 | 15 |
//! | [`CosineHemisphere`] | cos(theta)/pi (Malley) | 1e-15 | 15 |
//! | [`PhongLobe`] | cos^n(theta) | 4e-15 | 40 |
//! | [`VonMisesFisherLobe`] | e^(kappa cos(theta)), kappa from 0 to 1e8 | 4e-15 | 26 |
//! | [`SphericalTriangle`] | uniform on a spherical triangle (Arvo) | 2e-16/extent | 40 |
//! | [`SphericalRectangle`] | uniform on the image of a rectangle (Urena et al.) | 2e-16/extent | 200 to 450 |
//! | [`DensityMap`] | a luminance map, also times cos(theta), with a floor | 1e-14 | 310 to 370 |
//!
//! Round trips are errors of coordinates of the square; ns is the time of a sample on one core, for
//! maps of 128 x 64 texels.
//!
//! [`Oriented`] rotates a map. The functions [`archimedes`], [`concentric_disk`] and
//! [`cosine_hemisphere`] are the bare maps.
//!
//! # Examples
//!
//! The solid angle that a light subtends, weighted by the cosine, from 256 points of a grid:
//!
//! ```
//! use glam::DVec3;
//! use sphvar_warps::{SphericalRectangle, Warp};
//!
//! let corner = DVec3::new(-1.0, -1.0, 2.0);
//! let light = SphericalRectangle::new(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
//! let mut sum = 0.0;
//! for k in 0..256 {
//!     let point = [(f64::from(k % 16) + 0.5) / 16.0, (f64::from(k / 16) + 0.5) / 16.0];
//!     let sample = light.sample(point);
//!     sum += sample.point.z / sample.density / 256.0;
//! }
//! assert!((sum - 0.752_275).abs() < 1e-3);
//! # Ok::<(), sphvar_warps::Error>(())
//! ```

mod archimedes;
mod concentric;
mod concentric_warps;
mod density_map;
mod error;
mod lobes;
mod newton;
mod octahedral;
mod oriented;
mod polar;
mod rectangle;
mod triangle;
mod uniform_cap;
mod warp;

pub use archimedes::archimedes;
pub use concentric::{concentric_disk, cosine_hemisphere, cosine_hemisphere_pdf};
pub use concentric_warps::{ConcentricDisk, ConcentricHemisphere, CosineHemisphere};
pub use density_map::{DensityMap, Interpolation};
pub use error::Error;
pub use lobes::{PhongLobe, VonMisesFisherLobe};
pub use octahedral::OctahedralSphere;
pub use oriented::Oriented;
pub use rectangle::SphericalRectangle;
pub use triangle::SphericalTriangle;
pub use uniform_cap::UniformCap;
pub use warp::{Measure, Support, Warp, WarpSample};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
