use std::hint::black_box;
use std::ops::Range;

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use crate::geometry::bundle::Bundle;
use crate::geometry::cone::{CLOSE, Cone, NEAR};
use crate::geometry::height::{HEIGHT_ROUNDING, exact_height};
use crate::geometry::hierarchy::{Child, Node, SLACK, WIDTH};
use crate::geometry::hit::Front;
use crate::geometry::triangles::Triangles;

/// The number of rays that traverse the hierarchy together, so that a node or triangle is fetched
/// once for all of them. Groups of them share a bit.
const STREAM: usize = 256;
const GROUP: usize = 16;
/// One bit per group of a stream.
type Groups = u16;

/// The enlargement of boxes in units of their distance from the origin: eight roundings, which
/// cover the boxes relative to the origin, the directions and the distances.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// An occlusion query for many directions from one point.
pub(crate) struct Stream<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) triangles: &'a Triangles,
    pub(crate) origin: DVec3,
    pub(crate) normal: DVec3,
    /// Only triangles in front of this plane are intersected.
    pub(crate) front: Option<Front>,
    /// Directions and their reach. Successive directions should be close to each other.
    pub(crate) rays: &'a [(DVec3, f64)],
    /// Set to true where a ray meets a triangle.
    pub(crate) occluded: &'a mut [bool],
}

impl WithSimd for Stream<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { nodes, triangles, origin, normal, front, rays, occluded } = self;
        let mut tracer = Tracer {
            simd,
            hierarchy: nodes,
            triangles,
            origin,
            scaled_origin: origin * triangles.scale,
            front,
            near: NEAR * origin.abs().max_element() * triangles.scale,
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
    hierarchy: &'a [Node],
    triangles: &'a Triangles,
    /// In the coordinates of vertices and of the hierarchy.
    origin: DVec3,
    scaled_origin: DVec3,
    front: Option<Front>,
    /// The effect of rounding of the origin.
    near: f64,
    bundle: Bundle<STREAM>,
    /// The reciprocals of the components of the directions.
    inverses: [[f32; STREAM]; 3],
    /// The groups that have undecided rays.
    open: Groups,
    /// Nodes to visit and ranges of triangles to test, with their groups.
    nodes: Vec<(u32, Groups)>,
    leaves: Vec<(Range<usize>, Groups)>,
}

impl<S: Simd> Tracer<'_, S> {
    #[inline(always)]
    fn start(&mut self, rays: &[(DVec3, f64)], normal: Vec3) {
        self.bundle.fill(rays.iter().copied());
        self.bundle.decide_below(self.simd, normal);
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

    /// Visits nodes depth first. Much of the time is spent waiting for memory. Nodes are therefore
    /// prefetched when they are found, long before their visit, and the triangles of all leaves of
    /// a node before the first of them is tested, so that several memory accesses overlap.
    #[inline(always)]
    fn trace(&mut self, octant: usize) {
        self.nodes.clear();
        self.nodes.push((0, self.open));
        while let Some((index, groups)) = self.nodes.pop() {
            if groups & self.open == 0 {
                continue;
            }
            self.visit(index, groups & self.open, octant);
            for (range, _) in &self.leaves {
                for place in range.clone() {
                    let [a, _, c] = self.triangles.corners(place);
                    black_box((a.x, c.z));
                }
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

    /// Records the children of a node that any ray of the groups intersects.
    #[inline(always)]
    fn visit(&mut self, index: u32, groups: Groups, octant: usize) {
        let node = &self.hierarchy[index as usize];
        let met = self.children_met(node, groups);
        for place in 0..WIDTH {
            let child = place ^ octant;
            if met[child] == 0 {
                continue;
            }
            match node.child(child) {
                Some(Child::Triangles { first, count }) => {
                    self.leaves.push((first..first + count, met[child]));
                }
                Some(Child::Node(index)) => {
                    let node = &self.hierarchy[index as usize];
                    black_box((node.base.x, node.max[2][WIDTH - 1]));
                    self.nodes.push((index, met[child]));
                }
                None => (),
            }
        }
    }

    /// Marks the rays that intersect the triangle.
    #[inline(always)]
    fn meet(&mut self, place: usize, groups: Groups) {
        if groups == 0 {
            return;
        }
        let scale = self.triangles.scale;
        let corners = self.triangles.corners(place);
        if self.front.is_some_and(|front| !front.holds_part_of(&corners)) {
            return;
        }
        let relative = corners.map(|corner| (corner - self.origin) * scale);
        let [u, v] = [corners[1], corners[2]].map(|corner| (corner - corners[0]) * scale);
        let normal = u.cross(v);
        let mut height = normal.dot(relative[0]);
        let size = u.abs().max(v.abs()).max_element();
        let distance = relative[0].abs().max_element();
        let near = self.near + NEAR * (distance + size);
        let is_close = height.abs() <= (CLOSE * (distance + size) + 3.0 * near) * size * size;
        let mut goes_through = false;
        // The possible rounding of the height, and of the point: its distance from the plane times
        // the normal.
        if is_close && height.abs() <= (HEIGHT_ROUNDING * distance + 3.0 * near) * size * size {
            height = exact_height(corners.map(|c| c * scale), self.scaled_origin);
            goes_through = height.abs() <= near * normal.length();
        }
        let mut cone = Cone::new(relative, normal, height);
        if is_close {
            cone.widen(relative, if goes_through { near } else { 0.0 });
        }
        self.decide(&cone, groups);
        if goes_through {
            self.decide(&cone.other_side(), groups);
        }
    }

    /// Marks the rays that are in the cone.
    #[inline(always)]
    fn decide(&mut self, cone: &Cone<3>, mut groups: Groups) {
        while let Some(group) = take_first(&mut groups) {
            let mut decided = true;
            for v in vectors_of::<S>(group) {
                let rays = self.bundle.rays::<S>(v);
                let rays = rays.without(self.simd, cone.meet(self.simd, &rays));
                self.bundle.set(v, rays);
                decided &= rays.all_decided(self.simd);
            }
            if decided {
                self.open &= !(1 << group);
            }
        }
    }

    /// Returns, for each child, the groups with a ray that intersects it.
    #[inline(always)]
    fn children_met(&self, node: &Node, mut groups: Groups) -> [Groups; WIDTH] {
        let simd = self.simd;
        let base = (node.base - self.scaled_origin).as_vec3().to_array();
        let [x, y, z] = std::array::from_fn(|axis| {
            planes(&node.min[axis], &node.max[axis], base[axis], node.extent[axis])
        });
        let mut met = [0; WIDTH];
        while let Some(group) = take_first(&mut groups) {
            for v in vectors_of::<S>(group) {
                let rays = self.bundle.rays::<S>(v);
                let inverses = self.inverses.each_ref().map(|lane| S::as_simd_f32s(lane).0[v]);
                for child in 0..WIDTH {
                    if !node.has_child(child) {
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

/// Returns the vectors that make up a group.
#[inline(always)]
fn vectors_of<S: Simd>(group: usize) -> Range<usize> {
    let n = GROUP / S::F32_LANES;
    group * n..(group + 1) * n
}

/// Removes the lowest group from the set and returns it.
#[inline(always)]
fn take_first(groups: &mut Groups) -> Option<usize> {
    if *groups == 0 {
        return None;
    }
    let group = groups.trailing_zeros() as usize;
    *groups &= *groups - 1;
    Some(group)
}

/// Returns the permutation of a node's children that puts those that a direction meets last first.
#[inline(always)]
fn octant_of(dir: DVec3) -> usize {
    usize::from(dir.x >= 0.0) << 2 | usize::from(dir.y >= 0.0) << 1 | usize::from(dir.z >= 0.0)
}

/// Returns the reciprocal of a component of directions; it is finite, so that its product with 0 is
/// not NaN.
#[inline(always)]
fn inverse<S: Simd>(simd: S, component: S::f32s) -> S::f32s {
    let smallest = simd.splat_f32s(1e-20);
    let tiny = simd.less_than_f32s(simd.abs_f32s(component), smallest);
    simd.div_f32s(simd.splat_f32s(1.0), simd.select_f32s(tiny, smallest, component))
}

/// Returns the lower and upper planes of the children of a node.
#[inline(always)]
fn planes(min: &[u8; WIDTH], max: &[u8; WIDTH], base: f32, extent: f32) -> [[f32; WIDTH]; 2] {
    let mut planes = [[0.0; WIDTH]; 2];
    let slack = ROUNDING * (base.abs() + 256.0 * extent) + SLACK * extent;
    for child in 0..WIDTH {
        planes[0][child] = f32::from(min[child]) * extent + (base - slack);
        planes[1][child] = f32::from(max[child]) * extent + (base + slack);
    }
    planes
}

/// Returns the distances at which rays are between two planes.
#[inline(always)]
fn slab<S: Simd>(simd: S, inverse: S::f32s, min: f32, max: f32) -> [S::f32s; 2] {
    let a = simd.mul_f32s(inverse, simd.splat_f32s(min));
    let b = simd.mul_f32s(inverse, simd.splat_f32s(max));
    [simd.min_f32s(a, b), simd.max_f32s(a, b)]
}
