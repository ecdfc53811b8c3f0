use glam::{DVec3, Vec3};
use pulp::Simd;

use crate::bundle::{Rays, dot};

/// A convex polygon as rays from one point see it, in single precision: which of many directions meet it.
///
/// The planes through the point and the edges are computed in double precision, see [`meet`](crate::quad::meet). Rounding
/// of normals, directions and dot products then is at most [`ROUNDING`] times the sum of a normal's components. Edges
/// are moved out by as much, so that no ray that meets a surface of several polygons is lost between them: it could
/// be at a corner, where the signs for three or more planes need not agree with any direction.
///
/// Roundings in double precision, which matter for points that are nearly on an edge, are in the margins too.
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

/// Planes nearer to a point than this, in units of its largest coordinate and of the largest distance of a corner, may go
/// through it: rays from there meet what is on either side.
///
/// A point that was computed on a surface is off by two roundings of each coordinate, and the corners' differences from it
/// by another: sqrt(3) times 3 halves of an EPSILON.
pub(crate) const NEAR: f64 = 3.0 * f64::EPSILON;

impl<const N: usize> Cone<N> {
    /// A polygon that no ray meets.
    pub(crate) const NONE: Self = Self {
        edges: [Vec3::ZERO; N],
        margins: [0.0; N],
        normal: Vec3::ZERO,
        height: f32::INFINITY,
    };

    /// The polygon with these corners, relative to the rays' origin, and this normal of any length, on the side of
    /// it that `height` says, which is that of the corners along the normal.
    #[inline(always)]
    pub(crate) fn new(corners: [DVec3; N], normal: DVec3, height: f64) -> Self {
        let side = 1f64.copysign(height);
        let mut cone = Self::NONE;
        for i in 0..N {
            let (a, b) = (corners[i], corners[(i + 1) % N]);
            let (sum, difference) = (a + b, b - a);
            let edge = (side * sum.cross(difference)).as_vec3();
            let product = sum.abs().max_element() * difference.abs().max_element();
            #[expect(clippy::cast_possible_truncation, reason = "see the type")]
            let rounding = (EDGE_ROUNDING * product) as f32;
            cone.edges[i] = edge;
            cone.margins[i] = ROUNDING * (edge.x.abs() + edge.y.abs() + edge.z.abs()) + rounding;
        }
        cone.normal = (side * normal).as_vec3();
        // Never 0, so that what is edge on is not met.
        #[expect(clippy::cast_possible_truncation, reason = "see the type")]
        let height = (height.abs() as f32).max(f32::MIN_POSITIVE);
        cone.height = height;
        cone
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
