use std::mem::swap;
use std::ops::Range;

use glam::{DVec3, Vec3};
use prefetch_index::prefetch_index;
use pulp::{Simd, WithSimd};

use crate::geometry::bundle::Bundle;
use crate::geometry::cone::{CLOSE, Cone, NEAR};
use crate::geometry::height::{HEIGHT_ROUNDING, exact_height};
use crate::geometry::hierarchy::{Child, Node, SLACK, WIDTH};
use crate::geometry::hit::Front;

/// The number of rays that traverse the hierarchy together, so that a node or triangle is fetched
/// once for all of them.
const STREAM: usize = 256;

/// The number of eighths of a vector from which its rays are tested together; see
/// [`Tracer::children_met`].
const DENSE: usize = 5;

/// The lower and upper planes of the children of a node, by axis.
type Planes = [[[f32; WIDTH]; 2]; 3];

/// The enlargement of boxes in units of their distance from the origin: eight roundings, which
/// cover the boxes relative to the origin, the directions and the distances.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// An occlusion query for many directions from one point.
pub(crate) struct Stream<'a> {
    pub(crate) nodes: &'a [Node],
    /// The corners of triangles, and the factor of the hierarchy's coordinates.
    pub(crate) triangles: &'a [[DVec3; 3]],
    pub(crate) scale: f64,
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
        let Self { nodes, triangles, scale, origin, normal, front, rays, occluded } = self;
        let mut tracer = Tracer {
            simd,
            hierarchy: nodes,
            triangles,
            scale,
            origin,
            scaled_origin: origin * scale,
            front,
            near: NEAR * origin.abs().max_element() * scale,
            bundle: Bundle::new(),
            inverses: [[0.0; STREAM]; 3],
            open: RaySet::EMPTY,
            nodes: Vec::new(),
            leaves: Vec::new(),
            next_leaves: Vec::new(),
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
    triangles: &'a [[DVec3; 3]],
    scale: f64,
    /// In the coordinates of vertices and of the hierarchy.
    origin: DVec3,
    scaled_origin: DVec3,
    front: Option<Front>,
    /// The effect of rounding of the origin.
    near: f64,
    bundle: Bundle<STREAM>,
    /// The reciprocals of the components of the directions.
    inverses: [[f32; STREAM]; 3],
    /// The undecided rays.
    open: RaySet,
    /// Nodes to visit and ranges of triangles to test, with the rays that intersect their boxes.
    nodes: Vec<(u32, RaySet)>,
    leaves: Vec<(Range<usize>, RaySet)>,
    /// The leaves that the last visit found.
    next_leaves: Vec<(Range<usize>, RaySet)>,
}

impl<S: Simd> Tracer<'_, S> {
    #[inline(always)]
    fn start(&mut self, rays: &[(DVec3, f64)], normal: Vec3) {
        self.bundle.fill(rays.iter().copied());
        self.bundle.decide_below(self.simd, normal);
        self.open = RaySet(self.bundle.open());
        for v in 0..rays.len().div_ceil(S::F32_LANES) {
            let rays = self.bundle.rays::<S>(v);
            for (inverses, component) in self.inverses.iter_mut().zip(rays.dirs) {
                S::as_mut_simd_f32s(inverses).0[v] = inverse(self.simd, component);
            }
        }
    }

    /// Visits nodes approximately depth first. Much of the time is spent waiting for memory. Nodes
    /// and triangles are therefore prefetched when they are found. There are two visits between
    /// finding a node and its own, and triangles are tested after the visit that follows the one
    /// that found them.
    #[inline(always)]
    fn trace(&mut self, octant: usize) {
        self.nodes.clear();
        self.nodes.push((0, self.open));
        let mut next = None;
        while let Some((index, rays)) = next.take().or_else(|| self.nodes.pop()) {
            next = self.nodes.pop();
            let rays = rays.and(&self.open);
            if rays.is_empty() {
                continue;
            }
            self.visit(index, &rays, octant);
            self.test_leaves();
            swap(&mut self.leaves, &mut self.next_leaves);
        }
        self.test_leaves();
    }

    /// Tests the triangles of the leaves that the visit before the last one found.
    #[inline(always)]
    fn test_leaves(&mut self) {
        for i in 0..self.leaves.len() {
            let (range, rays) = self.leaves[i].clone();
            for primitive in range {
                self.meet(primitive, &rays.and(&self.open));
            }
        }
        self.leaves.clear();
    }

    /// Records the children of a node that any of the rays intersects.
    #[inline(always)]
    fn visit(&mut self, index: u32, rays: &RaySet, octant: usize) {
        let node = &self.hierarchy[index as usize];
        let met = self.children_met(node, rays);
        for place in 0..WIDTH {
            let child = place ^ octant;
            if met[child].is_empty() {
                continue;
            }
            match node.child(child) {
                Some(Child::Triangles { first, count }) => {
                    for corners in &self.triangles[first..first + count] {
                        prefetch_index(corners, 0);
                        prefetch_index(corners[2].as_ref(), 2);
                    }
                    self.next_leaves.push((first..first + count, met[child]));
                }
                Some(Child::Node(index)) => {
                    let node = &self.hierarchy[index as usize];
                    prefetch_index(node.base.as_ref(), 0);
                    prefetch_index(node.max[2].as_slice(), WIDTH - 1);
                    self.nodes.push((index, met[child]));
                }
                None => (),
            }
        }
    }

    /// Marks those of the rays that intersect the triangle.
    #[inline(always)]
    fn meet(&mut self, place: usize, rays: &RaySet) {
        if rays.is_empty() {
            return;
        }
        let (scale, corners) = (self.scale, self.triangles[place]);
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
        self.decide(&cone, rays);
        if goes_through {
            self.decide(&cone.other_side(), rays);
        }
    }

    /// Marks those of the rays that are in the cone.
    #[inline(always)]
    fn decide(&mut self, cone: &Cone<3>, rays: &RaySet) {
        for word in 0..RaySet::WORDS {
            let mut rest = rays.0[word];
            while rest != 0 {
                let first = first_lane::<S>(rest);
                let lanes = rest & lanes_from::<S>(first);
                rest &= !lanes;
                let vector = (64 * word + first) / S::F32_LANES;
                let hit = cone.meet(self.simd, &self.bundle.rays::<S>(vector));
                if self.simd.first_true_m32s(hit) == S::F32_LANES {
                    continue;
                }
                let decided = bits_of(self.simd, hit) << first & lanes;
                self.open.0[word] &= !decided;
                self.bundle.decide(64 * word, decided);
            }
        }
    }

    /// Returns, for each child, the rays that intersect its box.
    ///
    /// Most nodes are reached by a few rays of a stream, which test all children at once; where they
    /// fill most of a vector of rays, this tests one child after the other. Both give the same
    /// results.
    #[inline(always)]
    fn children_met(&self, node: &Node, rays: &RaySet) -> [RaySet; WIDTH] {
        let base = (node.base - self.scaled_origin).as_vec3().to_array();
        let planes = std::array::from_fn(|axis| {
            planes(&node.min[axis], &node.max[axis], base[axis], node.extent[axis])
        });
        let present = node.present();
        let mut met = [RaySet::EMPTY; WIDTH];
        for word in 0..RaySet::WORDS {
            let mut rest = rays.0[word];
            while rest != 0 {
                let first = first_lane::<S>(rest);
                let mut lanes = rest & lanes_from::<S>(first);
                rest &= !lanes;
                if lanes.count_ones() as usize * 8 >= DENSE * S::F32_LANES {
                    let vector = (64 * word + first) / S::F32_LANES;
                    for child in (0..WIDTH).filter(|child| present >> child & 1 != 0) {
                        let through = self.rays_through(&planes, child, vector);
                        if self.simd.first_true_m32s(through) != S::F32_LANES {
                            met[child].0[word] |= bits_of(self.simd, through) << first & lanes;
                        }
                    }
                    continue;
                }
                while lanes != 0 {
                    let bit = lanes & lanes.wrapping_neg();
                    lanes ^= bit;
                    let ray = (64 * word + bit.trailing_zeros() as usize) % STREAM;
                    let inverse = self.inverses.each_ref().map(|inverses| inverses[ray]);
                    let mut children =
                        children_of_ray(&planes, inverse, self.bundle.reach(ray)) & present;
                    while children != 0 {
                        met[children.trailing_zeros() as usize % WIDTH].0[word] |= bit;
                        children &= children - 1;
                    }
                }
            }
        }
        met
    }

    /// Returns which rays of a vector intersect the box of a child.
    #[inline(always)]
    fn rays_through(&self, planes: &Planes, child: usize, vector: usize) -> S::m32s {
        let simd = self.simd;
        let mut enter = simd.splat_f32s(0.0);
        let mut leave = self.bundle.rays::<S>(vector).reaches;
        for (inverses, [min, max]) in self.inverses.iter().zip(planes) {
            let inverse = S::as_simd_f32s(inverses).0[vector];
            let a = simd.mul_f32s(inverse, simd.splat_f32s(min[child]));
            let b = simd.mul_f32s(inverse, simd.splat_f32s(max[child]));
            enter = simd.max_f32s(enter, simd.min_f32s(a, b));
            leave = simd.min_f32s(leave, simd.max_f32s(a, b));
        }
        simd.less_than_or_equal_f32s(enter, leave)
    }
}

/// Returns one bit for each child of a node whose box a ray intersects, by the operations of
/// [`Tracer::rays_through`]; vectorized by the compiler.
#[inline(always)]
fn children_of_ray(planes: &Planes, inverse: [f32; 3], reach: f32) -> u32 {
    // Unlike those of f32, these are single instructions; there are no NaN.
    #[inline(always)]
    fn min(a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    #[inline(always)]
    fn max(a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    let mut bits = [0u32; WIDTH];
    for child in 0..WIDTH {
        let (mut enter, mut leave) = (0.0, reach);
        for axis in 0..3 {
            let a = inverse[axis] * planes[axis][0][child];
            let b = inverse[axis] * planes[axis][1][child];
            enter = max(enter, min(a, b));
            leave = min(leave, max(a, b));
        }
        bits[child] = if enter <= leave { 1 << child } else { 0 };
    }
    bits.iter().fold(0, |bits, bit| bits | bit)
}

/// Returns the first lane of the vector that has the first ray of a word.
#[inline(always)]
fn first_lane<S: Simd>(word: u64) -> usize {
    word.trailing_zeros() as usize / S::F32_LANES * S::F32_LANES
}

/// Returns the bits of a vector's lanes.
#[inline(always)]
fn lanes_from<S: Simd>(first: usize) -> u64 {
    (u64::MAX >> (64 - S::F32_LANES)) << first
}

/// A set of rays of a stream.
#[derive(Clone, Copy, Debug)]
struct RaySet([u64; Self::WORDS]);

impl RaySet {
    const WORDS: usize = STREAM / 64;
    const EMPTY: Self = Self([0; Self::WORDS]);

    #[inline(always)]
    fn and(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] & other.0[word]))
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.0.iter().fold(0, |all, word| all | word) == 0
    }
}

/// Returns one bit per lane of a mask.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "an integer from 0 to 65535"
)]
fn bits_of<S: Simd>(simd: S, mask: S::m32s) -> u64 {
    const BITS: [f32; 16] = [
        1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0, 4096.0, 8192.0,
        16384.0, 32768.0,
    ];
    let bits = S::as_simd_f32s(&BITS).0[0];
    simd.reduce_sum_f32s(simd.select_f32s(mask, bits, simd.splat_f32s(0.0))) as u64
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
