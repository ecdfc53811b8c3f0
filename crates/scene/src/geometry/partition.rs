use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

use crate::geometry::bounds::Bounds;

/// The number of intervals of centres that are distinguished when a range is split.
const BINS: usize = 16;
/// The depth from which ranges are split into halves by count. No distribution of sizes then makes
/// the tree deep, and the time is n log n.
const MAX_DEPTH: usize = 64;

/// Returns the binary tree over boxes; each leaf is a single box.
pub(crate) fn binary_tree(boxes: &[Bounds]) -> Bvh2 {
    let mut partition = Partition::new(boxes);
    let whole = partition.part(0, boxes.len());
    // In f32, for areas only; the coordinates relative to the centre keep them accurate.
    let center = whole.bounds.center();
    let node = |part: &Part, first_child: usize| {
        let [min, max] = [part.bounds.min, part.bounds.max].map(|p| (p - center).as_vec3a());
        let (count, first) = if part.len() == 1 { (1, part.start) } else { (0, first_child) };
        Bvh2Node::new(Aabb::new(min, max), count, index_of(first))
    };
    let mut nodes = vec![node(&whole, 1)];
    let mut to_split = vec![(0, whole, 0)];
    while let Some((index, part, depth)) = to_split.pop() {
        if part.len() == 1 {
            continue;
        }
        let first_child = nodes.len();
        nodes[index] = node(&part, first_child);
        for (i, half) in partition.halves(part, depth < MAX_DEPTH).into_iter().enumerate() {
            nodes.push(node(&half, 0));
            to_split.push((first_child + i, half, depth + 1));
        }
    }
    let mut tree = Bvh2::zeroed(0);
    tree.nodes = nodes;
    tree.primitive_indices = partition.order;
    tree.children_are_ordered_after_parents = true;
    tree
}

#[expect(clippy::cast_possible_truncation, reason = "there are at most 2^28 triangles")]
fn index_of(length: usize) -> u32 {
    length as u32
}

/// Boxes to be sorted into ranges.
#[derive(Debug)]
struct Partition<'a> {
    boxes: &'a [Bounds],
    order: Vec<u32>,
}

/// A range of boxes.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: usize,
    end: usize,
    bounds: Bounds,
}

impl Part {
    fn len(&self) -> usize {
        self.end - self.start
    }
}

impl<'a> Partition<'a> {
    fn new(boxes: &'a [Bounds]) -> Self {
        Self { boxes, order: (0..).take(boxes.len()).collect() }
    }

    fn part(&self, start: usize, end: usize) -> Part {
        let boxes = self.order[start..end].iter().map(|&i| self.boxes[i as usize]);
        Part { start, end, bounds: boxes.fold(Bounds::NONE, Bounds::and) }
    }

    /// Splits a range where the sum over the two parts of area times number of members is smallest,
    /// or by count if the centres coincide or `by_area` is not set.
    fn halves(&mut self, part: Part, by_area: bool) -> [Part; 2] {
        let members = &mut self.order[part.start..part.end];
        let centers = members.iter().map(|&i| self.boxes[i as usize].center());
        let around = Bounds::around(centers);
        let best = if by_area { best_plane(self.boxes, members, &around) } else { None };
        let boxes = self.boxes;
        let middle = match best {
            Some((axis, plane)) => {
                let bin = |i: u32| bin_of(&boxes[i as usize], &around, axis);
                // A stable partition, so that the order is that of the list.
                let (mut left, right): (Vec<u32>, Vec<u32>) =
                    members.iter().partition(|&&i| bin(i) < plane);
                let middle = left.len();
                left.extend(right);
                members.copy_from_slice(&left);
                middle
            }
            None => {
                let axis = (around.max - around.min).max_position();
                let key =
                    |i: u32| (boxes[i as usize].center()[axis], half_area(&boxes[i as usize]));
                let middle = members.len() / 2;
                members.select_nth_unstable_by(middle, |&i, &j| {
                    let ((x, a), (y, b)) = (key(i), key(j));
                    x.total_cmp(&y).then(a.total_cmp(&b)).then(i.cmp(&j))
                });
                middle
            }
        };
        let middle = part.start + middle;
        [self.part(part.start, middle), self.part(middle, part.end)]
    }
}

/// Returns the axis and the first bin on the upper side of the best plane; `None` if all centres
/// coincide.
fn best_plane(boxes: &[Bounds], members: &[u32], around: &Bounds) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if around.max[axis] <= around.min[axis] {
            continue;
        }
        let mut bins = [(0usize, Bounds::NONE); BINS];
        for &i in members {
            let (count, bounds) = &mut bins[bin_of(&boxes[i as usize], around, axis)];
            *count += 1;
            *bounds = bounds.and(boxes[i as usize]);
        }
        let join = |(n, a): (usize, Bounds), (m, b): (usize, Bounds)| (n + m, a.and(b));
        let cost = |(n, bounds): (usize, Bounds)| half_area(&bounds) * n as f64;
        let mut above = [(0, Bounds::NONE); BINS + 1];
        for i in (0..BINS).rev() {
            above[i] = join(above[i + 1], bins[i]);
        }
        let mut below = (0, Bounds::NONE);
        for plane in 1..BINS {
            below = join(below, bins[plane - 1]);
            if below.0 == 0 || above[plane].0 == 0 {
                continue;
            }
            let cost = cost(below) + cost(above[plane]);
            if best.is_none_or(|(min_cost, ..)| cost < min_cost) {
                best = Some((cost, axis, plane));
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number from 0 to BINS, which is cut to the last bin"
)]
fn bin_of(item: &Bounds, around: &Bounds, axis: usize) -> usize {
    let share = (item.center()[axis] - around.min[axis]) / (around.max[axis] - around.min[axis]);
    ((share * BINS as f64) as usize).min(BINS - 1)
}

fn half_area(bounds: &Bounds) -> f64 {
    let DVec3 { x, y, z } = bounds.max - bounds.min;
    if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
}
