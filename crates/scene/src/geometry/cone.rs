use glam::{DVec3, Vec3};
use pulp::Simd;

use crate::geometry::bundle::{Rays, dot};

/// A convex polygon as rays from one point see it, in single precision: which of many directions meet it.
///
/// The planes through the point and the edges are computed in double precision, see [`meet`](crate::geometry::quad::meet). Rounding
/// of normals, directions and dot products then is at most [`ROUNDING`] times the sum of a normal's components. Edges
/// are moved out by as much, so that no ray that meets a surface of several polygons is lost between them: it could
/// be at a corner, where the signs for three or more planes need not agree with any direction.
///
/// Roundings in double precision matter for points that are nearly on an edge, see [`Self::widen`].
///
/// A direction is judged wrongly only if it passes within twice `sqrt(3) ROUNDING` radians of an edge, or of the
/// polygon's plane where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone<const N: usize> {
    edges: [Vec3; N],
    margins: [f32; N],
    normal: Vec3,
    height: f32,
}

/// Half an `f32::EPSILON` for each of: components of normal and direction, product, two sums.
const ROUNDING: f32 = 2.5 * f32::EPSILON;

/// Roundings of an edge's plane in double precision, in units of the largest components of `a + b` and `b - a`: half an
/// `EPSILON` for each of them, their product, and the difference of two products, in three components.
const EDGE_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Edges that a point is within 3e-9 of, in units of the distance of their ends, are off by more than cones allow for;
/// then it is as near to the plane of the polygon, of which the product with the normal is up to three times that.
pub(crate) const CLOSE: f64 = 1e-7;

/// Planes nearer to a point than this, in units of its largest coordinate and of the largest distance of a corner, may go
/// through it: rays from there meet what is on either side.
///
/// A point that was computed on a surface is off by two roundings of each coordinate, and the corners' differences from it
/// by another: sqrt(3) halves of an EPSILON for each, of which two are of the larger.
pub(crate) const NEAR: f64 = 2.0 * f64::EPSILON;

impl<const N: usize> Cone<N> {
    /// The fields before they are set, for arrays: memory is filled with zeros faster than with other values.
    pub(crate) const UNSET: Self =
        Self { edges: [Vec3::ZERO; N], margins: [0.0; N], normal: Vec3::ZERO, height: 0.0 };

    /// The polygon with these corners, relative to the rays' origin, and this normal of any length, on the side of
    /// it that `height` says, which is that of the corners along the normal.
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
        // Never 0, so that what is edge on is not met.
        #[expect(clippy::cast_possible_truncation, reason = "see the type")]
        let height = (height.abs() as f32).max(f32::MIN_POSITIVE);
        cone.height = height;
        cone
    }

    /// Moves the edges out by what roundings in double precision may make of them, for points nearly on one, and by what
    /// an error `near` of the origin may.
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

    /// The same polygon if the origin is on the other side of its plane.
    #[inline(always)]
    pub(crate) fn other_side(self) -> Self {
        Self { edges: self.edges.map(|edge| -edge), normal: -self.normal, ..self }
    }

    /// Which of the rays meet the polygon; those already answered may or may not be among them.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, rays: &Rays<S>) -> S::m32s {
        let mut least = dot(simd, &rays.dirs, self.edges[0], self.margins[0]);
        for (&edge, &margin) in self.edges[1..].iter().zip(&self.margins[1..]) {
            least = simd.min_f32s(least, dot(simd, &rays.dirs, edge, margin));
        }
        // The distance is height / approach. Endless rays along the plane give NaN, which is not near.
        let approach = dot(simd, &rays.dirs, self.normal, 0.0);
        let risen = simd.mul_f32s(approach, rays.reaches);
        let inside = simd.greater_than_or_equal_f32s(least, simd.splat_f32s(0.0));
        let near = simd.greater_than_or_equal_f32s(risen, simd.splat_f32s(self.height));
        simd.and_m32s(inside, near)
    }
}
