use glam::{DQuat, DVec4};

/// Maximum number of quaternions of a leaf.
const LEAF: usize = 8;

/// A k-d tree over the quaternions q and -q of rotations.
#[derive(Clone, Debug)]
pub(super) struct QuaternionTree {
    /// The quaternions with the numbers of their rotations; the median of each range, along its
    /// axis, is in the middle.
    items: Vec<(DVec4, u32)>,
    /// The axis of the range whose median is at this index.
    axes: Vec<u8>,
}

impl QuaternionTree {
    #[expect(clippy::cast_possible_truncation, reason = "patterns have at most u32::MAX elements")]
    pub(super) fn new(rotations: &[DQuat]) -> Self {
        let both = |(i, q): (usize, &DQuat)| {
            let q = DVec4::from(*q);
            [(q, i as u32), (-q, i as u32)]
        };
        let mut items: Vec<_> = rotations.iter().enumerate().flat_map(both).collect();
        let mut axes = vec![0; items.len()];
        divide(&mut items, &mut axes);
        Self { items, axes }
    }

    /// Calls `visit(item, rotation, squared chord, bound)` for the quaternions whose squared chord
    /// from `p` is below `bound`, which a call may reduce.
    pub(super) fn visit(
        &self,
        p: DVec4,
        bound: &mut f64,
        visit: &mut impl FnMut(DVec4, u32, f64, &mut f64),
    ) {
        self.visit_range(0, self.items.len(), p, bound, visit);
    }

    fn visit_range(
        &self,
        start: usize,
        end: usize,
        p: DVec4,
        bound: &mut f64,
        visit: &mut impl FnMut(DVec4, u32, f64, &mut f64),
    ) {
        let mut test = |&(q, rotation): &(DVec4, u32), bound: &mut f64| {
            let squared = q.distance_squared(p);
            if squared < *bound {
                visit(q, rotation, squared, bound);
            }
        };
        if end - start <= LEAF {
            self.items[start..end].iter().for_each(|item| test(item, bound));
            return;
        }
        let middle = usize::midpoint(start, end);
        test(&self.items[middle], bound);
        let axis = usize::from(self.axes[middle]);
        let across = p[axis] - self.items[middle].0[axis];
        let (low, high) = ((start, middle), (middle + 1, end));
        let (near, far) = if across < 0.0 { (low, high) } else { (high, low) };
        self.visit_range(near.0, near.1, p, bound, visit);
        if across * across < *bound {
            self.visit_range(far.0, far.1, p, bound, visit);
        }
    }
}

/// Arranges a range so that its median along the widest axis is in the middle, and so on in both
/// halves.
#[expect(clippy::cast_possible_truncation, reason = "an axis is below 4")]
fn divide(items: &mut [(DVec4, u32)], axes: &mut [u8]) {
    if items.len() <= LEAF {
        return;
    }
    let start = (DVec4::INFINITY, DVec4::NEG_INFINITY);
    let (low, high) = items.iter().fold(start, |(low, high), (q, _)| (low.min(*q), high.max(*q)));
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    axes[middle] = axis as u8;
    let (low, high) = items.split_at_mut(middle);
    let (low_axes, high_axes) = axes.split_at_mut(middle);
    divide(low, low_axes);
    divide(&mut high[1..], &mut high_axes[1..]);
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec4};

    use super::QuaternionTree;
    use crate::{Purpose, RotationPattern, Streams};

    #[test]
    fn it_finds_all_quaternions_within_a_chord() {
        let mut rng = Streams::new(4, Purpose::Pattern, 0).realization(0);
        let mut sets: Vec<Vec<DQuat>> = [1, 4, 5, 9, 200]
            .map(|n| RotationPattern::Uniform.build(n).unwrap().sample(&mut rng).unwrap().points)
            .to_vec();
        sets.push(vec![DQuat::IDENTITY; 50]);
        for rotations in sets {
            let tree = QuaternionTree::new(&rotations);
            let mut sorted: Vec<_> = tree.items.iter().map(|item| item.1).collect();
            sorted.sort_unstable();
            assert!((0..2 * rotations.len()).all(|k| sorted[k] as usize == k / 2));
            let centres = RotationPattern::Uniform.build(20).unwrap().sample(&mut rng).unwrap();
            for p in centres.points.into_iter().chain(rotations.iter().copied()) {
                let p = DVec4::from(p);
                for bound in [0.0, 0.01, 0.5, 5.0] {
                    let mut found = Vec::new();
                    tree.visit(p, &mut { bound }, &mut |_, k, squared, _| found.push((k, squared)));
                    let all = rotations.iter().flat_map(|&q| [DVec4::from(q), -DVec4::from(q)]);
                    let expected = all.filter(|q| q.distance_squared(p) < bound).count();
                    assert_eq!(found.len(), expected, "{} rotations", rotations.len());
                }
            }
        }
    }
}
