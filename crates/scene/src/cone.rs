use glam::{DVec3, Vec3};
use pulp::Simd;

use crate::bundle::{Rays, dot};

/// A convex polygon as rays from one point see it, in single precision: which of many directions meet it.
///
/// The planes through the point and the edges are computed in double precision, see [`meet`](crate::quad::meet). The
/// dot product with a direction then is off by at most four roundings, so that a direction is judged wrongly only
/// if it passes within 4 `f32::EPSILON` radians of an edge, or within that of the polygon's plane where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone<const N: usize> {
    edges: [Vec3; N],
    normal: Vec3,
    height: f32,
}

impl<const N: usize> Cone<N> {
    /// A polygon that no ray meets.
    pub(crate) const NONE: Self =
        Self { edges: [Vec3::ZERO; N], normal: Vec3::ZERO, height: f32::INFINITY };

    /// The polygon with these corners, relative to the rays' origin, and this normal of any length.
    #[inline(always)]
    pub(crate) fn new(corners: [DVec3; N], normal: DVec3) -> Self {
        let height = normal.dot(corners[0]);
        let side = height.signum();
        let mut edges = [Vec3::ZERO; N];
        for i in 0..N {
            let (a, b) = (corners[i], corners[(i + 1) % N]);
            edges[i] = (side * (a + b).cross(b - a)).as_vec3();
        }
        // Never 0, so that what is edge on is not met.
        #[expect(clippy::cast_possible_truncation, reason = "see the type")]
        let height = (height.abs() as f32).max(f32::MIN_POSITIVE);
        Self { edges, normal: (side * normal).as_vec3(), height }
    }

    /// Which of the rays meet the polygon; those already answered may or may not be among them.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, rays: &Rays<S>) -> S::m32s {
        let mut least = dot(simd, &rays.dirs, self.edges[0]);
        for &edge in &self.edges[1..] {
            least = simd.min_f32s(least, dot(simd, &rays.dirs, edge));
        }
        // The distance is height / approach. Endless rays along the plane give NaN, which is not near.
        let approach = dot(simd, &rays.dirs, self.normal);
        let risen = simd.mul_f32s(approach, rays.reaches);
        let inside = simd.greater_than_or_equal_f32s(least, simd.splat_f32s(0.0));
        let near = simd.greater_than_or_equal_f32s(risen, simd.splat_f32s(self.height));
        simd.and_m32s(inside, near)
    }
}
