//! Maps from the unit square to the disk, the sphere and the hemisphere that preserve areas or have
//! a known density.
//!
//! - [`concentric_disk`]: the square to the disk, areas multiplied by pi (Shirley and Chiu 1997).
//! - [`cosine_hemisphere`] with [`cosine_hemisphere_pdf`]: directions of density cos(theta)/pi
//!   (Malley).
//! - [`archimedes`]: height and longitude to a direction, area-preserving.
//!
//! # Examples
//!
//! ```
//! use sphvar_warps::{cosine_hemisphere, cosine_hemisphere_pdf};
//!
//! let dir = cosine_hemisphere(0.3, 0.8);
//! assert_eq!(cosine_hemisphere_pdf(dir), dir.z / std::f64::consts::PI);
//! ```

mod archimedes;
mod concentric;

pub use archimedes::archimedes;
pub use concentric::{concentric_disk, cosine_hemisphere, cosine_hemisphere_pdf};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
