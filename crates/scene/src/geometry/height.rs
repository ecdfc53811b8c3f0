use glam::DVec3;
use robust::{Coord3D, orient3d};

/// The rounding of the product of a normal and a vector, for components up to 1 of the vector and
/// of the sides that span the normal: 48 halves of an EPSILON.
pub(crate) const HEIGHT_ROUNDING: f64 = 24.0 * f64::EPSILON;

/// Returns the dot product of `(b - a) x (c - a)` and `a - origin`, with the correct sign.
#[cold]
pub(crate) fn exact_height(corners: [DVec3; 3], origin: DVec3) -> f64 {
    let [a, b, c] = corners.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, Coord3D { x: origin.x, y: origin.y, z: origin.z })
}
