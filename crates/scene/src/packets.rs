use glam::{DVec3, UVec2, Vec3, Vec3A};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::traverse;
use pulp::{Simd, WithSimd};

use crate::bundle::{BUNDLE, Bundle, Rays};
use crate::cone::Cone;
use crate::mesh::SIZE;

/// Which directions from one point meet triangles, as many at a time as the processor has lanes.
pub(crate) struct Packets<'a> {
    pub(crate) hierarchy: &'a CwBvh,
    /// The triangles in the order of the hierarchy.
    pub(crate) corners: &'a [[Vec3; 3]],
    pub(crate) origin: DVec3,
    pub(crate) normal: DVec3,
    /// Directions and how far they reach. Those in succession should be near each other.
    pub(crate) rays: &'a [(DVec3, f64)],
    /// Set where a ray meets a triangle.
    pub(crate) occluded: &'a mut [bool],
}

/// What the boxes are enlarged by on every side: four roundings of the largest coordinates, for those of the origin,
/// of the boxes relative to it and of distances.
const SLACK: f32 = 2.0 * f32::EPSILON * SIZE as f32;

impl WithSimd for Packets<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut bundle = Bundle::new();
        let normal = self.normal.as_vec3();
        let chunks = self.rays.chunks(BUNDLE).zip(self.occluded.chunks_mut(BUNDLE));
        for (rays, occluded) in chunks {
            bundle.fill(rays.iter().copied());
            let parts = rays.chunks(S::F32_LANES).zip(occluded.chunks_mut(S::F32_LANES));
            for (v, (dirs, occluded)) in parts.enumerate() {
                let mut rays = bundle.rays(simd, v, normal);
                let towards = dirs[dirs.len() / 2].0;
                trace(simd, self.hierarchy, self.corners, self.origin, towards, &mut rays);
                rays.report(occluded);
            }
        }
    }
}

#[inline(always)]
fn trace<S: Simd>(
    simd: S,
    hierarchy: &CwBvh,
    corners: &[[Vec3; 3]],
    origin: DVec3,
    towards: DVec3,
    rays: &mut Rays<S>,
) {
    let inverses = inverses(simd, rays);
    let near_origin = origin.as_vec3a();
    let mut state = hierarchy.new_traversal(towards.as_vec3a());
    let mut node;
    'all: {
        if rays.all_answered(simd) {
            break 'all;
        }
        traverse!(
            hierarchy,
            node,
            state,
            children_met(simd, node, near_origin, &inverses, rays.reaches, state.oct_inv4),
            {
                let relative = corners[state.primitive_id as usize].map(|c| c.as_dvec3() - origin);
                let [a, b, c] = relative;
                let cone = Cone::new(relative, (b - a).cross(c - a));
                *rays = rays.without(simd, cone.meet(simd, rays));
                if rays.all_answered(simd) {
                    break 'all;
                }
            }
        );
    }
}

/// One over the components of the directions; none is infinite, so that its product with 0 is a number.
#[inline(always)]
fn inverses<S: Simd>(simd: S, rays: &Rays<S>) -> [S::f32s; 3] {
    let (one, least) = (simd.splat_f32s(1.0), simd.splat_f32s(1e-20));
    rays.dirs.map(|component| {
        let tiny = simd.less_than_f32s(simd.abs_f32s(component), least);
        simd.div_f32s(one, simd.select_f32s(tiny, least, component))
    })
}

/// The bits of the children that any of the rays meets, as the traversal wants them.
#[inline(always)]
fn children_met<S: Simd>(
    simd: S,
    node: &CwBvhNode,
    origin: Vec3A,
    inverses: &[S::f32s; 3],
    reaches: S::f32s,
    oct_inv4: u32,
) -> u32 {
    let extent = node.compute_extent();
    let base = Vec3A::from(node.p) - origin;
    let [x, y, z] = [
        planes(&node.child_min_x, &node.child_max_x, base.x, extent.x),
        planes(&node.child_min_y, &node.child_max_y, base.y, extent.y),
        planes(&node.child_min_z, &node.child_max_z, base.z, extent.z),
    ];
    let (bits, indices) = node.get_child_and_index_bits(oct_inv4);
    let (bits, indices) = (bits.to_le_bytes(), indices.to_le_bytes());
    let mut met = 0;
    for child in 0..8 {
        let [x0, x1] = slab(simd, inverses[0], x[0][child], x[1][child]);
        let [y0, y1] = slab(simd, inverses[1], y[0][child], y[1][child]);
        let [z0, z1] = slab(simd, inverses[2], z[0][child], z[1][child]);
        let enter = simd.max_f32s(simd.max_f32s(x0, y0), simd.max_f32s(z0, simd.splat_f32s(0.0)));
        let leave = simd.min_f32s(simd.min_f32s(x1, y1), simd.min_f32s(z1, reaches));
        let through = simd.less_than_or_equal_f32s(enter, leave);
        if simd.first_true_m32s(through) != S::F32_LANES {
            met |= u32::from(bits[child]) << indices[child];
        }
    }
    met
}

/// The lower and upper planes of the children of a node.
#[inline(always)]
fn planes(min: &[u8; 8], max: &[u8; 8], base: f32, extent: f32) -> [[f32; 8]; 2] {
    let (lower, upper) = (base - SLACK, base + SLACK);
    [min.map(|q| f32::from(q) * extent + lower), max.map(|q| f32::from(q) * extent + upper)]
}

/// The distances at which rays are between two planes.
#[inline(always)]
fn slab<S: Simd>(simd: S, inverse: S::f32s, min: f32, max: f32) -> [S::f32s; 2] {
    let a = simd.mul_f32s(inverse, simd.splat_f32s(min));
    let b = simd.mul_f32s(inverse, simd.splat_f32s(max));
    [simd.min_f32s(a, b), simd.max_f32s(a, b)]
}
