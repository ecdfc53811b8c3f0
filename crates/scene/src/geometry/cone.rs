use glam::{DVec3, Vec3};
use pulp::Simd;

use crate::geometry::bundle::{Rays, dot};

/// A convex polygon seen from the common origin of rays, in single precision, for testing which
/// directions intersect it.
///
/// The planes through the origin and the edges are computed in double precision, see
/// [`meet`](crate::geometry::quad::meet). The rounding of normals, directions and dot products is
/// then at most [`ROUNDING`] times the sum of a normal's absolute components. Edges are moved
/// outwards by that amount, so that no ray that intersects a surface of several polygons is lost
/// between them. Otherwise a ray could be lost at a corner, where the signs for three or more
/// planes need not be consistent with any direction.
///
/// Rounding in double precision matters for points that are nearly on an edge, see [`Self::widen`].
///
/// A direction can be misjudged only if it passes within `2 sqrt(3) ROUNDING` radians of an edge,
/// or of the polygon's plane where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone<const N: usize> {
    edges: [Vec3; N],
    margins: [f32; N],
    normal: Vec3,
    height: f32,
}

/// Half an `f32::EPSILON` for each of these: component of the normal, component of the direction,
/// product, two sums.
const ROUNDING: f32 = 2.5 * f32::EPSILON;

/// The rounding of an edge's plane in double precision, in units of the largest components of
/// `a + b` and `b - a`: half an `EPSILON` for each of them, for their product, and for the
/// difference of two products, in three components.
const EDGE_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Edges within 3e-9 of the point, in units of the length of the edge, have larger errors than
/// cones allow for. The point is then equally close to the plane of the polygon, and the product
/// with the normal is up to three times that distance.
pub(crate) const CLOSE: f64 = 1e-7;

/// Planes closer to a point than this, in units of its largest coordinate and of the largest
/// distance of a corner, may contain it: rays from the point then intersect surfaces on either
/// side.
///
/// A point computed on a surface has an error of two roundings of each coordinate, and the
/// differences of the corners from it have a third one: sqrt(3) halves of an EPSILON for each, two
/// of which are of the larger size.
pub(crate) const NEAR: f64 = 2.0 * f64::EPSILON;

impl<const N: usize> Cone<N> {
    /// The initial value of array elements: filling memory with zeros is faster than with other
    /// values.
    pub(crate) const UNSET: Self =
        Self { edges: [Vec3::ZERO; N], margins: [0.0; N], normal: Vec3::ZERO, height: 0.0 };

    /// Returns the polygon with these corners, relative to the origin of the rays. The normal may
    /// have any length; `height` is the dot product of the normal and the corners, and its sign
    /// tells on which side of the plane the origin lies.
    #[inline(always)]
    pub(crate) fn new(corners: [DVec3; N], normal: DVec3, height: f64) -> Self {
        let side = 1f64.copysign(height);
        let mut cone = Self::UNSET;
        for i in 0..N {
            let (a, b) = (corners[i], corners[(i + 1) % N]);
            let edge = (side * (a + b).cross(b - a)).as_vec3();
            cone.edges[i] = edge;
            cone.margins[i] = ROUNDING * (edge.x.abs() + edge.y.abs() + edge.z.abs());
        }
        cone.normal = (side * normal).as_vec3();
        // Never 0, so that polygons seen edge-on are not intersected.
        #[expect(clippy::cast_possible_truncation, reason = "see the type")]
        let height = (height.abs() as f32).max(f32::MIN_POSITIVE);
        cone.height = height;
        cone
    }

    /// Moves the edges outwards by the possible double-precision rounding, for points nearly on an
    /// edge, and by the effect of an error `near` of the origin.
    #[cold]
    pub(crate) fn widen(&mut self, corners: [DVec3; N], near: f64) {
        for (i, margin) in self.margins.iter_mut().enumerate() {
            let (a, b) = (corners[i], corners[(i + 1) % N]);
            let off = EDGE_ROUNDING * (a + b).abs().max_element() + 2.0 * near;
            #[expect(clippy::cast_possible_truncation, reason = "see the type")]
            let off = (off * (b - a).abs().max_element()) as f32;
            *margin += off;
        }
    }

    /// Returns the polygon as seen from an origin on the other side of its plane.
    #[inline(always)]
    pub(crate) fn other_side(self) -> Self {
        Self { edges: self.edges.map(|edge| -edge), normal: -self.normal, ..self }
    }

    /// Returns which of the rays intersect the polygon; rays that are already decided may be
    /// included or not.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, rays: &Rays<S>) -> S::m32s {
        let mut min = dot(simd, &rays.dirs, self.edges[0], self.margins[0]);
        for (&edge, &margin) in self.edges[1..].iter().zip(&self.margins[1..]) {
            min = simd.min_f32s(min, dot(simd, &rays.dirs, edge, margin));
        }
        // The distance is height / approach. Unbounded rays along the plane give NaN, which does
        // not compare as near.
        let approach = dot(simd, &rays.dirs, self.normal, 0.0);
        let risen = simd.mul_f32s(approach, rays.reaches);
        let inside = simd.greater_than_or_equal_f32s(min, simd.splat_f32s(0.0));
        let near = simd.greater_than_or_equal_f32s(risen, simd.splat_f32s(self.height));
        simd.and_m32s(inside, near)
    }
}
