use glam::DVec3;

use crate::{Error, MAX_COORDINATE};

/// The maximum distance of corners from their plane, in lengths of the longer diagonal: the
/// rounding of data with six digits.
const FLATNESS: f64 = 1e-6;
/// The minimum length, above which products of three coordinates do not underflow.
const MIN_SIZE: f64 = 1e-100;

/// A plane convex quadrilateral: a wall, a side of a block, or a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    corners: [DVec3; 4],
    normal: DVec3,
}

impl Quad {
    /// Returns the quadrilateral with these corners, in order around it.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Quad`] if the corners are not finite or beyond 1e100, not in a plane (to
    /// 1e-6 of the diagonal), or not in order around a convex shape with an area. Three corners may
    /// be collinear.
    pub fn new(corners: [DVec3; 4]) -> Result<Self, Error> {
        let reject = |expected| Err(Error::Quad { expected });
        if !corners.iter().flat_map(|c| c.to_array()).all(|x| x.abs() <= MAX_COORDINATE) {
            return reject("finite coordinates within 1e100");
        }
        let [a, b, c, d] = corners;
        let Some(normal) = normal_between(c - a, d - b) else {
            return reject("a positive area");
        };
        let size = (c - a).length().max((d - b).length());
        if (b - a).dot(normal).abs() > FLATNESS * size {
            return reject("four corners in a plane");
        }
        let triples = [a, b, c, d].into_iter().zip([b, c, d, a]).zip([c, d, a, b]);
        for ((before, corner), after) in triples {
            if (corner - before).cross(after - corner).dot(normal) < -f64::EPSILON * size * size {
                return reject("a convex shape with its corners in order");
            }
        }
        Ok(Self { corners, normal })
    }

    /// Returns the corners in order.
    pub fn corners(&self) -> [DVec3; 4] {
        self.corners
    }

    /// Returns the unit normal, on the side from which the corners are counterclockwise.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Returns the area.
    pub fn area(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        0.5 * (c - a).cross(d - b).length()
    }

    /// Returns the point at `(u, v)` of the unit square by bilinear interpolation: corners 0 and 1
    /// are at `(0, 0)` and `(1, 0)`, corners 2 and 3 at `(1, 1)` and `(0, 1)`. For a parallelogram
    /// the map preserves ratios of areas.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.corners;
        a.lerp(b, u).lerp(d.lerp(c, u), v)
    }

    /// Returns the distance, in lengths of `dir`, at which a ray meets the quadrilateral from
    /// either side, edges included.
    ///
    /// Returns `None` for rays in its plane, for rays that start there, and if the quadrilateral is
    /// smaller than the rounding of its distance.
    pub fn intersect(&self, origin: DVec3, dir: DVec3) -> Option<f64> {
        let corners = self.corners.map(|c| c - origin);
        let [a, b, c, d] = corners;
        // The cone over a point would contain every direction.
        (a != c && b != d).then(|| meet(corners, self.normal, dir))?
    }
}

/// Returns the unit normal of the plane of two vectors; `None` if they are parallel or shorter than
/// 1e-100.
pub(crate) fn normal_between(u: DVec3, v: DVec3) -> Option<DVec3> {
    let size = u.abs().max(v.abs()).max_element();
    // The squares of lengths of order 1 neither overflow nor underflow.
    (size >= MIN_SIZE).then(|| (u / size).cross(v / size).try_normalize())?
}

/// Returns the distance at which a ray from 0 meets the convex polygon with these corners.
///
/// A direction d meets it if it lies in the cone over the polygon, on the same side of all planes
/// through 0 and an edge: `d . (a x b) >= 0`. The plane is computed as `(a + b) x (b - a)`, which
/// equals `2 a x b` with less cancellation and is exactly opposite for the neighbour that has the
/// edge in the other direction: no ray passes between them.
pub(crate) fn meet<const N: usize>(corners: [DVec3; N], normal: DVec3, dir: DVec3) -> Option<f64> {
    let height = normal.dot(corners[0]);
    let side = height.signum();
    let approach = side * normal.dot(dir);
    let inside = (0..N).all(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % N]);
        side * dir.dot((a + b).cross(b - a)) >= 0.0
    });
    (inside && height != 0.0 && approach > 0.0).then(|| height.abs() / approach)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_that_are_not_plane_and_convex_are_rejected() {
        let [o, x, y, z] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert!(Quad::new([o, x, x + y, y]).is_ok());
        assert!(Quad::new([o, x, 2.0 * x, y]).is_ok(), "a triangle with a corner on its side");
        for corners in [
            [o, x, x + y + z, y],
            [o, x + y, x, y],
            [o, x, 0.2 * (x + y), y],
            [o, x, 2.0 * x, 3.0 * x],
            [o; 4],
            [o, x, x + y, y * f64::NAN],
            [o, x * 1e200, (x + y) * 1e200, y * 1e200],
        ] {
            assert!(Quad::new(corners).is_err(), "{corners:?}");
        }
    }

    #[test]
    fn points_and_area_of_a_square() {
        let quad =
            Quad::new([DVec3::ZERO, 2.0 * DVec3::X, DVec3::new(2.0, 2.0, 0.0), 2.0 * DVec3::Y])
                .expect("a square");
        assert!((quad.area() - 4.0).abs() < 4.0 * f64::EPSILON);
        assert_eq!(quad.point(0.25, 0.75), DVec3::new(0.5, 1.5, 0.0));
        assert_eq!(quad.normal(), DVec3::Z);
        assert_eq!(quad.intersect(DVec3::new(0.5, 0.5, 3.0), -DVec3::Z), Some(3.0));
        assert_eq!(quad.intersect(DVec3::new(0.5, 0.5, 3.0), DVec3::Z), None);
        // From a distance at which it is a point.
        assert_eq!(quad.intersect(DVec3::new(1e30, 2e30, 3e30), -DVec3::Z), None);
    }
}
