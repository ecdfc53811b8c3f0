use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;

use crate::geometry::bounds::Bounds;
use crate::geometry::pages::Pages;
use crate::geometry::partition::binary_tree;

/// The number of children of a node.
pub(crate) const WIDTH: usize = 8;
/// The maximum number of triangles in a leaf, limited by the two bits that a node stores.
const MAX_LEAF: u32 = 3;

/// A bounding-volume hierarchy over triangles, with up to eight children per node (Ylitie, Karras
/// and Laine 2017).
///
/// The boxes of children are stored as integer multiples of powers of two from the node's corner.
/// The corner is in f64, so that small objects on a large ground are resolved.
#[derive(Clone, Debug)]
pub(crate) struct Hierarchy {
    pub(crate) nodes: Pages<Node>,
    /// For each place of a triangle in the hierarchy, its index in the input list.
    pub(crate) order: Box<[u32]>,
}

/// A node; 96 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Node {
    /// The corner with the smallest coordinates.
    pub(crate) base: DVec3,
    /// The length of a unit of the children's bounds along each axis.
    pub(crate) extent: [f32; 3],
    first_node: u32,
    first_triangle: u32,
    /// Bounds of the children along each axis, rounded outwards.
    pub(crate) min: [[u8; WIDTH]; 3],
    pub(crate) max: [[u8; WIDTH]; 3],
    /// Two bits per child: its number of triangles, or 0 if it is a node or absent.
    sizes: u16,
    /// One bit per child: set if it is a node.
    inner: u8,
    /// Without a meaning.
    padding: u8,
}

/// The kind of a child.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Child {
    Node(u32),
    Triangles { first: usize, count: usize },
}

/// The largest value of a child's bound.
const FULL: f64 = 255.0;

/// The minimum length of a unit. Boxes enlarged by a part of a unit then cover the rounding of
/// directions along their planes.
const MIN_EXTENT: f64 = 1.0 / (1u64 << 35) as f64;

impl Hierarchy {
    /// Returns the hierarchy over boxes, in coordinates in which the whole has a size of about
    /// 2^16.
    ///
    /// The bvh crate builds the wide tree from the binary one and sorts children by octants; its
    /// boxes, in f32 relative to the whole, are replaced.
    pub(crate) fn new(boxes: &[Bounds]) -> Self {
        let wide = bvh2_to_cwbvh(&binary_tree(boxes), MAX_LEAF, true, false);
        let order = wide.primitive_indices;
        let mut nodes = vec![Node::EMPTY; wide.nodes.len()];
        let mut bounds = vec![Bounds::NONE; wide.nodes.len()];
        // Children have larger indices than their parents.
        for (index, wide) in wide.nodes.iter().enumerate().rev() {
            let mut children = [Bounds::NONE; WIDTH];
            let mut sizes = 0;
            for (place, child) in children.iter_mut().enumerate() {
                if wide.is_child_empty(place) {
                    continue;
                }
                if wide.is_leaf(place) {
                    let (first, count) = wide.child_primitives(place);
                    let triangles = &order[first as usize..(first + count) as usize];
                    let boxes = triangles.iter().map(|&i| boxes[i as usize]);
                    *child = boxes.fold(Bounds::NONE, Bounds::and);
                    sizes |= u16::try_from(count).unwrap_or(0) << (2 * place);
                } else {
                    *child = bounds[wide.child_node_index(place) as usize];
                }
            }
            bounds[index] = children.into_iter().fold(Bounds::NONE, Bounds::and);
            nodes[index] = Node {
                first_node: wide.child_base_idx,
                first_triangle: wide.primitive_base_idx,
                sizes,
                inner: wide.imask,
                ..Node::around(&children)
            };
        }
        Self { nodes: Pages::new(nodes.into_iter()), order: order.into() }
    }
}

impl Hierarchy {
    /// Calls `visit` with ranges of triangles whose boxes a ray may intersect, approximately from
    /// near to far. `visit` returns a distance in lengths of `dir`; boxes beyond it may be skipped
    /// from then on.
    ///
    /// Boxes are enlarged to cover the rounding of corners in
    /// [`WatertightRay`](crate::geometry::ray::WatertightRay).
    pub(crate) fn visit_along(
        &self,
        origin: DVec3,
        dir: DVec3,
        mut visit: impl FnMut(usize, usize) -> f64,
    ) {
        // Finite, so that the product with 0 is not NaN.
        let inverse = DVec3::from_array(
            dir.to_array().map(|d| 1.0 / if d.abs() < MIN_COMPONENT { MIN_COMPONENT } else { d }),
        );
        let mut farthest = f64::INFINITY;
        let nodes = &*self.nodes;
        let mut stack = vec![(0.0, Child::Node(0))];
        while let Some((enter, child)) = stack.pop() {
            if enter > farthest {
                continue;
            }
            let node = match child {
                Child::Node(index) => &nodes[index as usize],
                Child::Triangles { first, count } => {
                    farthest = visit(first, count);
                    continue;
                }
            };
            let first = stack.len();
            let base = node.base - origin;
            let extent = DVec3::from_array(node.extent.map(f64::from));
            let rounding = ROUNDINGS * f64::EPSILON * (base.abs() + 256.0 * extent).max_element();
            let slack = f64::from(SLACK) * extent + rounding;
            for place in 0..WIDTH {
                let Some(child) = node.child(place) else { continue };
                let bound = |bounds: &[[u8; WIDTH]; 3]| {
                    let [x, y, z] = bounds.each_ref().map(|axis| f64::from(axis[place]));
                    base + extent * DVec3::new(x, y, z)
                };
                let a = (bound(&node.min) - slack) * inverse;
                let b = (bound(&node.max) + slack) * inverse;
                let enter = a.min(b).max_element().max(0.0);
                // Covers the rounding of products.
                let enter = enter * (1.0 - 4.0 * f64::EPSILON);
                if enter <= a.max(b).min_element() && enter <= farthest {
                    stack.push((enter, child));
                }
            }
            stack[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
    }
}

/// The enlargement of boxes on every side, in units of their node: much more than their rounding to
/// units.
pub(crate) const SLACK: f32 = 1.0 / 32.0;

/// The rounding of a corner's position across a ray, in units of its distance from the origin.
const ROUNDINGS: f64 = 8.0;

/// The minimum absolute value of a direction's component; smaller ones are replaced by it.
const MIN_COMPONENT: f64 = 1e-100;

impl Node {
    const EMPTY: Self = Self {
        base: DVec3::ZERO,
        extent: [0.0; 3],
        first_node: 0,
        first_triangle: 0,
        min: [[0; WIDTH]; 3],
        max: [[0; WIDTH]; 3],
        sizes: 0,
        inner: 0,
        padding: 0,
    };

    /// Returns a node with the boxes of its children; empty boxes are absent children.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "powers of two within f32, and numbers from 0 to 255"
    )]
    fn around(children: &[Bounds; WIDTH]) -> Self {
        let whole = children.iter().copied().fold(Bounds::NONE, Bounds::and);
        let mut node = Self { base: whole.min, ..Self::EMPTY };
        for axis in 0..3 {
            let length = whole.max[axis] - whole.min[axis];
            let mut extent = MIN_EXTENT;
            while extent * FULL < length {
                extent *= 2.0;
            }
            node.extent[axis] = extent as f32;
            for (i, child) in children.iter().enumerate().filter(|(_, child)| !child.is_empty()) {
                // The rounding of the differences is negligible compared with the enlargement of
                // boxes.
                let place = |x: f64| (x - whole.min[axis]) / extent;
                node.min[axis][i] = place(child.min[axis]).floor().clamp(0.0, FULL) as u8;
                node.max[axis][i] = place(child.max[axis]).ceil().clamp(0.0, FULL) as u8;
            }
        }
        node
    }

    /// Returns the child at a place, if present.
    #[inline(always)]
    pub(crate) fn child(&self, place: usize) -> Option<Child> {
        let before = (1u32 << place) - 1;
        if self.inner & 1 << place != 0 {
            let n_before = (u32::from(self.inner) & before).count_ones();
            return Some(Child::Node(self.first_node + n_before));
        }
        let count = usize::from(self.sizes >> (2 * place) & 3);
        if count == 0 {
            return None;
        }
        let before = self.sizes & ((1u16 << (2 * place)) - 1);
        let n_before = (before & 0x5555).count_ones() + 2 * (before & 0xaaaa).count_ones();
        let first = (self.first_triangle + n_before) as usize;
        Some(Child::Triangles { first, count })
    }

    /// Returns one bit for each place that has a child.
    #[inline(always)]
    pub(crate) fn present(&self) -> u32 {
        let leaves = (0..WIDTH).filter(|place| self.sizes >> (2 * place) & 3 != 0);
        leaves.fold(u32::from(self.inner), |bits, place| bits | 1 << place)
    }
}
