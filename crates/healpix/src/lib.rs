//! HEALPix indexing on the unit sphere: ring order for every nside from 1 to 2^29, nested order for powers of two, and
//! the equal-area coordinates inside a pixel.
//!
//! HEALPix (Gorski et al. 2005) cuts the sphere into `12 nside^2` pixels of equal area whose centres lie on
//! `4 nside - 1` rings of equal colatitude.
//!
//! ```
//! use sphvar_healpix::{Nside, PixelOrder, Ring, unit_direction};
//!
//! let order = Ring::new(Nside::new(18)?);
//! assert_eq!(order.n_pixels(), 3888);
//!
//! // From a direction to its pixel, and to the place in the pixel.
//! let dir = unit_direction(glam::DVec3::new(1.0, 2.0, 3.0))?;
//! let (pixel, u, v) = order.invert_uniform_point(dir);
//! assert_eq!(pixel, order.pixel(dir));
//!
//! // Lists are several times as fast.
//! let mut pixels = [0; 2];
//! order.pixels_into(&[dir, -dir], &mut pixels);
//! assert_eq!(pixels, [pixel, order.antipode(pixel)]);
//!
//! // And back; uniform u and v give a uniform direction in the pixel.
//! assert!(order.uniform_point(pixel, u, v).distance(dir) < 1e-14);
//! # Ok::<(), sphvar_healpix::Error>(())
//! ```
//!
//! # Structure
//! [`Nside`] is the checked resolution. [`Cell`] is a pixel without a number (face and place in the face) and has all
//! geometry. [`Ring`] and [`Nested`] are numberings of cells; what they share is the trait [`PixelOrder`].
//!
//! # Precision
//! Near the poles everything is computed from the distance to the pole, never from `1 - |z|`, so a pixel's centre is
//! found in that pixel at every resolution. `theta` is the colatitude in `[0, pi]`, `phi` the longitude, both in
//! radians; directions are unit vectors, which [`unit_direction`] makes of any finite vector other than zero.

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
