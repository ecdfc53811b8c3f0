use std::hint::black_box;
use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use pulp::{Simd, WithSimd};

use crate::bundle::Bundle;
use crate::cone::Cone;
use crate::mesh::SIZE;

/// Rays that go through the hierarchy together, so that a node or triangle is fetched once for all of them, and those
/// of them that share a bit.
const STREAM: usize = 256;
const GROUP: usize = 16;
/// A bit for each group of a stream.
type Groups = u16;

/// Nodes that are visited after a look at all of them.
const BATCH: usize = 2;

/// Children of a node.
const WIDTH: usize = 8;

/// What the boxes are enlarged by on every side: eight roundings of the largest coordinates, for those of the origin,
/// of the boxes relative to it and of distances.
const SLACK: f32 = 4.0 * f32::EPSILON * SIZE as f32;

/// Which directions from one point meet triangles.
pub(crate) struct Stream<'a> {
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

impl WithSimd for Stream<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { hierarchy, corners, origin, normal, rays, occluded } = self;
        let mut tracer = Tracer {
            simd,
            hierarchy,
            corners,
            origin,
            bundle: Bundle::new(),
            inverses: [[0.0; STREAM]; 3],
            open: 0,
            nodes: Vec::new(),
            leaves: Vec::new(),
        };
        for (rays, occluded) in rays.chunks(STREAM).zip(occluded.chunks_mut(STREAM)) {
            tracer.start(rays, normal.as_vec3());
            tracer.trace(octant_of(rays[rays.len() / 2].0));
            tracer.bundle.report(occluded);
        }
    }
}

struct Tracer<'a, S> {
    simd: S,
    hierarchy: &'a CwBvh,
    corners: &'a [[Vec3; 3]],
    origin: DVec3,
    bundle: Bundle<STREAM>,
    /// One over the components of the directions.
    inverses: [[f32; STREAM]; 3],
    /// Groups that have rays without an answer.
    open: Groups,
    /// Nodes to visit, and ranges of triangles to test, with the groups that they are for.
    nodes: Vec<(u32, Groups)>,
    leaves: Vec<(Range<usize>, Groups)>,
}

impl<S: Simd> Tracer<'_, S> {
    #[inline(always)]
    fn start(&mut self, rays: &[(DVec3, f64)], normal: Vec3) {
        self.bundle.fill(rays.iter().copied());
        self.bundle.answer_below(self.simd, normal);
        self.open = 0;
        for group in 0..rays.len().div_ceil(GROUP) {
            self.open |= 1 << group;
            for v in vectors_of::<S>(group) {
                let rays = self.bundle.rays::<S>(v);
                for (inverses, component) in self.inverses.iter_mut().zip(rays.dirs) {
                    S::as_mut_simd_f32s(inverses).0[v] = inverse(self.simd, component);
                }
            }
        }
    }

    /// Nodes are visited some at a time, after a look at all of them, and their triangles likewise: much of the time
    /// goes by waiting for memory, here for several places at once.
    #[inline(always)]
    fn trace(&mut self, octant: usize) {
        let root = (0, self.open);
        self.nodes.clear();
        self.nodes.push(root);
        while !self.nodes.is_empty() {
            let mut batch = [root; BATCH];
            let n_batch = self.nodes.len().min(BATCH);
            for entry in &mut batch[..n_batch] {
                *entry = self.nodes.pop().unwrap_or(root);
                let node = &self.hierarchy.nodes[entry.0 as usize];
                black_box((node.imask, node.child_max_z[WIDTH - 1]));
            }
            for &(index, groups) in &batch[..n_batch] {
                if groups & self.open != 0 {
                    self.visit(index, groups & self.open, octant);
                }
            }
            for (range, _) in &self.leaves {
                black_box((self.corners[range.start][0].x, self.corners[range.end - 1][2].z));
            }
            for i in 0..self.leaves.len() {
                let (range, groups) = self.leaves[i].clone();
                for primitive in range {
                    self.meet(primitive, groups & self.open);
                }
            }
            self.leaves.clear();
        }
    }

    /// Takes note of the children of a node that any of the groups' rays meets.
    #[inline(always)]
    fn visit(&mut self, index: u32, groups: Groups, octant: usize) {
        let node = &self.hierarchy.nodes[index as usize];
        let met = self.children_met(node, groups);
        for place in 0..WIDTH {
            let child = place ^ octant;
            if met[child] == 0 {
                continue;
            }
            if node.is_leaf(child) {
                let (first, count) = node.child_primitives(child);
                let range = first as usize..(first + count) as usize;
                self.leaves.push((range, met[child]));
            } else {
                self.nodes.push((node.child_node_index(child), met[child]));
            }
        }
    }

    /// Answers rays that meet the triangle.
    #[inline(always)]
    fn meet(&mut self, primitive: usize, mut groups: Groups) {
        if groups == 0 {
            return;
        }
        let [a, b, c] = self.corners[primitive];
        let [a, b, c] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
        let corners = [a - self.origin, b - self.origin, c - self.origin];
        let cone = Cone::new(corners, (b - a).cross(c - a));
        while let Some(group) = take_first(&mut groups) {
            let mut answered = true;
            for v in vectors_of::<S>(group) {
                let rays = self.bundle.rays::<S>(v);
                let rays = rays.without(self.simd, cone.meet(self.simd, &rays));
                self.bundle.set(v, rays);
                answered &= rays.all_answered(self.simd);
            }
            if answered {
                self.open &= !(1 << group);
            }
        }
    }

    /// For each child the groups that have a ray that meets it.
    #[inline(always)]
    fn children_met(&self, node: &CwBvhNode, mut groups: Groups) -> [Groups; WIDTH] {
        let simd = self.simd;
        let extent = node.compute_extent();
        let base = Vec3A::from(node.p) - self.origin.as_vec3a();
        let [x, y, z] = [
            planes(&node.child_min_x, &node.child_max_x, base.x, extent.x),
            planes(&node.child_min_y, &node.child_max_y, base.y, extent.y),
            planes(&node.child_min_z, &node.child_max_z, base.z, extent.z),
        ];
        let mut met = [0; WIDTH];
        while let Some(group) = take_first(&mut groups) {
            for v in vectors_of::<S>(group) {
                let rays = self.bundle.rays::<S>(v);
                let inverses = self.inverses.each_ref().map(|lane| S::as_simd_f32s(lane).0[v]);
                for child in 0..WIDTH {
                    if node.is_child_empty(child) {
                        continue;
                    }
                    let [x0, x1] = slab(simd, inverses[0], x[0][child], x[1][child]);
                    let [y0, y1] = slab(simd, inverses[1], y[0][child], y[1][child]);
                    let [z0, z1] = slab(simd, inverses[2], z[0][child], z[1][child]);
                    let zero = simd.splat_f32s(0.0);
                    let enter = simd.max_f32s(simd.max_f32s(x0, y0), simd.max_f32s(z0, zero));
                    let leave =
                        simd.min_f32s(simd.min_f32s(x1, y1), simd.min_f32s(z1, rays.reaches));
                    let through = simd.less_than_or_equal_f32s(enter, leave);
                    let any = simd.first_true_m32s(through) != S::F32_LANES;
                    met[child] |= Groups::from(any) << group;
                }
            }
        }
        met
    }
}

/// The vectors that make up a group.
#[inline(always)]
fn vectors_of<S: Simd>(group: usize) -> Range<usize> {
    let n = GROUP / S::F32_LANES;
    group * n..(group + 1) * n
}

/// The lowest group, which is taken out of the set.
#[inline(always)]
fn take_first(groups: &mut Groups) -> Option<usize> {
    if *groups == 0 {
        return None;
    }
    let group = groups.trailing_zeros() as usize;
    *groups &= *groups - 1;
    Some(group)
}

/// What exchanges a node's children so that those that a direction meets last come first.
#[inline(always)]
fn octant_of(dir: DVec3) -> usize {
    usize::from(dir.x >= 0.0) << 2 | usize::from(dir.y >= 0.0) << 1 | usize::from(dir.z >= 0.0)
}

/// One over a component of directions; not infinite, so that its product with 0 is a number.
#[inline(always)]
fn inverse<S: Simd>(simd: S, component: S::f32s) -> S::f32s {
    let least = simd.splat_f32s(1e-20);
    let tiny = simd.less_than_f32s(simd.abs_f32s(component), least);
    simd.div_f32s(simd.splat_f32s(1.0), simd.select_f32s(tiny, least, component))
}

/// The lower and upper planes of the children of a node.
#[inline(always)]
fn planes(min: &[u8; WIDTH], max: &[u8; WIDTH], base: f32, extent: f32) -> [[f32; WIDTH]; 2] {
    let mut planes = [[0.0; WIDTH]; 2];
    for child in 0..WIDTH {
        planes[0][child] = f32::from(min[child]) * extent + (base - SLACK);
        planes[1][child] = f32::from(max[child]) * extent + (base + SLACK);
    }
    planes
}

/// The distances at which rays are between two planes.
#[inline(always)]
fn slab<S: Simd>(simd: S, inverse: S::f32s, min: f32, max: f32) -> [S::f32s; 2] {
    let a = simd.mul_f32s(inverse, simd.splat_f32s(min));
    let b = simd.mul_f32s(inverse, simd.splat_f32s(max));
    [simd.min_f32s(a, b), simd.max_f32s(a, b)]
}
