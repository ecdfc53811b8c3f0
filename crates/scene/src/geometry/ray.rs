use std::cmp::Ordering;

use glam::DVec3;

use crate::geometry::height::{HEIGHT_ROUNDING, exact_height};

/// A ray that intersects every closed surface that it passes through: none is lost between
/// triangles that share a side or a corner (Woop, Benthin and Wald 2013).
///
/// Corners are sheared so that the ray runs along an axis. The transformed corner does not depend
/// on the triangle that it belongs to, and the signs of areas in the plane are exact. Triangles
/// that share corners therefore leave no point between them uncovered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WatertightRay {
    origin: DVec3,
    /// The axis of the largest component of the direction, and the two others.
    axes: [usize; 3],
    shear: [f64; 2],
    along: f64,
}

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// The distance in lengths of the direction.
    pub(crate) distance: f64,
    /// The barycentric coordinates of the point for the second and third corner.
    pub(crate) weights: [f64; 2],
}

impl WatertightRay {
    /// Returns the length of `dir` must be neither zero nor out of range.
    pub(crate) fn new(origin: DVec3, dir: DVec3) -> Self {
        let z = dir.abs().max_position();
        let [x, y] = [(z + 1) % 3, (z + 2) % 3];
        let along = dir[z];
        Self { origin, axes: [z, x, y], shear: [dir[x] / along, dir[y] / along], along }
    }

    /// Returns the corner relative to the ray: across it, and along the axis.
    fn place(&self, corner: DVec3) -> ([f64; 2], f64) {
        let [z, x, y] = self.axes.map(|axis| corner[axis] - self.origin[axis]);
        ([x - self.shear[0] * z, y - self.shear[1] * z], z)
    }

    /// Returns the intersection of the ray with the triangle, its sides included, ahead of the
    /// origin.
    ///
    /// Returns `None` for triangles seen edge-on, and for triangles whose plane contains the
    /// origin.
    pub(crate) fn meet(&self, corners: [DVec3; 3]) -> Option<Meeting> {
        let [(a, za), (b, zb), (c, zc)] = corners.map(|corner| self.place(corner));
        // Twice the areas of the triangles that the ray forms with the sides.
        let [u, v, w] = [area(b, c), area(c, a), area(a, b)];
        let sides = [u, v, w];
        if sides.iter().any(|&x| x < 0.0) && sides.iter().any(|&x| x > 0.0) {
            return None;
        }
        let sum = u + v + w;
        // A weighted mean with weights of one sign, so the depth lies between those of the corners.
        let distance = (u * za + v * zb + w * zc) / sum / self.along;
        // The height above the plane is the distance times this factor.
        let is_ahead = height(corners, self.origin) * (sum * self.along).signum() > 0.0;
        let distance = distance.max(f64::MIN_POSITIVE);
        let meeting = Meeting { distance, weights: [v / sum, w / sum] };
        (sum != 0.0 && is_ahead && distance.is_finite()).then_some(meeting)
    }
}

/// Returns the dot product of `(b - a) x (c - a)` and `a - origin`, with the correct sign.
fn height(corners: [DVec3; 3], origin: DVec3) -> f64 {
    let [a, b, c] = corners;
    let (u, v, w) = (b - a, c - a, a - origin);
    let size = u.abs().max(v.abs()).max_element();
    let height = u.cross(v).dot(w);
    let rounding = HEIGHT_ROUNDING * size * size * w.abs().max_element();
    if height.abs() <= rounding { exact_height(corners, origin) } else { height }
}

/// Returns twice the signed area of the triangle of 0 and two points, with the correct sign.
fn area(p: [f64; 2], q: [f64; 2]) -> f64 {
    let (left, right) = (p[0] * q[1], p[1] * q[0]);
    match left.partial_cmp(&right) {
        // Rounding is monotonic, so the difference of two different products is correct except for
        // its last digits; if the rounded products are equal, their rounding errors decide.
        Some(Ordering::Equal) => p[0].mul_add(q[1], -left) - p[1].mul_add(q[0], -right),
        _ => left - right,
    }
}

#[cfg(test)]
mod tests {
    use super::area;

    #[test]
    fn signs_of_areas_are_exact() {
        let up = 1.0 + f64::EPSILON;
        // up * up rounds to 1 + 2 EPSILON; the product is EPSILON^2 more.
        let (p, q) = ([up, 1.0 + 2.0 * f64::EPSILON], [1.0, up]);
        for (got, exact) in [
            (area(p, q), f64::EPSILON.powi(2)),
            (area(q, p), -f64::EPSILON.powi(2)),
            (area([3.0, 5.0], [3.0, 5.0]), 0.0),
        ] {
            assert_eq!(got.to_bits(), exact.to_bits(), "{got:e}, not {exact:e}");
        }
    }
}
