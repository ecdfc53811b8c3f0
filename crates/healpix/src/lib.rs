//! HEALPix indexing on the unit sphere: ring order for every nside from 1 to 2^29, nested order for
//! powers of two, and equal-area coordinates within a pixel.
//!
//! HEALPix (Gorski et al. 2005) partitions the sphere into `12 nside^2` pixels of equal area whose
//! centres lie on `4 nside - 1` rings of equal colatitude.
//!
//! # Structure
//!
//! [`Nside`] is a validated resolution. [`Cell`] is a pixel given by its face and its position in
//! the face, independent of a numbering; it implements all geometry. [`Ring`] and [`Nested`] are
//! numberings of cells with the common trait [`PixelOrder`].
//!
//! # Precision
//!
//! Near the poles all quantities are computed from the distance to the pole, never from `1 - |z|`,
//! so the centre of a pixel is located in that pixel at every resolution. `theta` is the colatitude
//! in `[0, pi]` and `phi` the longitude, both in radians. Directions are unit vectors;
//! [`unit_direction`] normalizes any finite nonzero vector.
//!
//! # Examples
//!
//! ```
//! use sphvar_healpix::{Nside, PixelOrder, Ring, unit_direction};
//!
//! let order = Ring::new(Nside::new(18)?);
//! assert_eq!(order.n_pixels(), 3888);
//!
//! // From a direction to its pixel and the coordinates within the pixel.
//! let dir = unit_direction(glam::DVec3::new(1.0, 2.0, 3.0))?;
//! let (pixel, u, v) = order.invert_uniform_point(dir);
//! assert_eq!(pixel, order.pixel(dir));
//!
//! // Slices are several times as fast as single calls.
//! let mut pixels = [0; 2];
//! order.pixels_into(&[dir, -dir], &mut pixels);
//! assert_eq!(pixels, [pixel, order.antipode(pixel)]);
//!
//! // The inverse: uniform u and v give a uniform direction in the pixel.
//! assert!(order.uniform_point(pixel, u, v).distance(dir) < 1e-14);
//! # Ok::<(), sphvar_healpix::Error>(())
//! ```

mod azimuth;
mod cell;
mod cell_map;
mod direction;
mod error;
mod lanes;
mod lists;
mod neighbours;
mod nested;
mod nside;
mod order;
mod ring;
mod ring_geometry;
mod zone;

pub use cell::Cell;
pub use direction::unit_direction;
pub use error::Error;
pub use nested::Nested;
pub use nside::Nside;
pub use order::PixelOrder;
pub use ring::Ring;
pub use ring_geometry::RingGeometry;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
