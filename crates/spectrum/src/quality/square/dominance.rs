//! Sums over pairs of points by a sweep in u and a tree in v, O(N log N).

/// The scale of numbers in [0, 1] that are summed as integers, so that sums have no rounding.
const UNIT: f64 = (1u64 << 63) as f64;

/// Sums of K moments over the points that the sweep has passed, by the rank of their v (a tree of
/// partial sums, Fenwick 1994).
struct Tree<const K: usize> {
    nodes: Vec<[u128; K]>,
}

impl<const K: usize> Tree<K> {
    /// Adds the moments of the point of a rank.
    fn add(&mut self, rank: usize, moments: [u128; K]) {
        let mut at = rank + 1;
        while at <= self.nodes.len() {
            self.nodes[at - 1].iter_mut().zip(moments).for_each(|(sum, moment)| *sum += moment);
            at += at & at.wrapping_neg();
        }
    }

    /// Returns the sums over all ranks below `rank`.
    fn below(&self, rank: usize) -> [u128; K] {
        let (mut sums, mut at) = ([0; K], rank);
        while at > 0 {
            sums.iter_mut().zip(self.nodes[at - 1]).for_each(|(sum, node)| *sum += node);
            at -= at & at.wrapping_neg();
        }
        sums
    }
}

/// Calls `f` for every point in the order of u, with the sums of the moments over the earlier
/// points with v not above and with v above its own. Points with equal coordinates are in the order
/// of their indices. Moments are numbers in [0, 1].
pub(super) fn sweep<const K: usize, E>(
    points: &[[f64; 2]],
    moments: impl Fn([f64; 2]) -> [f64; K],
    mut f: impl FnMut([f64; 2], [f64; K], [f64; K]) -> Result<(), E>,
) -> Result<(), E> {
    let order = |axis: usize| {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order
            .sort_unstable_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]).then(a.cmp(&b)));
        order
    };
    let mut ranks = vec![0; points.len()];
    order(1).into_iter().enumerate().for_each(|(rank, j)| ranks[j] = rank);
    let mut tree = Tree { nodes: vec![[0; K]; points.len()] };
    let mut totals = [0u128; K];
    let value = |sums: [u128; K]| sums.map(|sum| sum as f64 / UNIT);
    for j in order(0) {
        let below = tree.below(ranks[j]);
        let above = std::array::from_fn(|i| totals[i] - below[i]);
        f(points[j], value(below), value(above))?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "numbers in [0, 1]"
        )]
        let moments = moments(points[j]).map(|x| u128::from((x * UNIT) as u64));
        tree.add(ranks[j], moments);
        totals.iter_mut().zip(moments).for_each(|(total, moment)| *total += moment);
    }
    Ok(())
}
