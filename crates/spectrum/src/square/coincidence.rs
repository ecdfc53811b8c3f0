use sphvar_samplers::PointSet;
use sphvar_sh::ByAxis;

use crate::ExactSum;

/// Maximum distance on the circle, 2^-40, at which two coordinates count as equal. It covers the
/// rounding of shifts and of coordinates that are computed in different ways; coordinates in single
/// precision or of few digits that ought to be equal are equal.
///
/// Coordinates this close add coherently up to frequencies near 2^38. A fraction `N 2^-39` of N
/// independent points is this close by chance.
const SAME_COORDINATE: f64 = 1.0 / (1u64 << 40) as f64;

/// Returns the mean power of a set of points of the square at high frequencies: off the axes, of
/// (k, 0) and of (0, k).
///
/// Two points contribute `2 w_j w_k cos(2 pi k . (p_j - p_k))/sum w^2` to the power at frequency k.
/// The average of this over frequencies vanishes off the axes unless the points coincide, and on an
/// axis unless their coordinates are equal. With the sums W of the weights of coincident points and
/// of points with equal coordinates,
///
/// ```text
/// off: sum_points W^2 / sum w^2,   u: sum_coordinates W^2 / sum w^2,   v: the same
/// ```
///
/// All are exactly 1 if no coordinates are equal; a regular grid of n x n points has n on both
/// axes. Coordinates at a distance modulo 1 of at most 2^-40 count as equal.
///
/// # Performance
///
/// O(N log N), for sorts.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::PointSet;
/// use sphvar_spectrum::square_tail_power;
///
/// let column = PointSet::new(vec![[0.5, 0.1], [0.5, 0.3], [0.5, 0.8]]);
/// let power = square_tail_power(&column);
/// assert_eq!((power.off, power.u, power.v), (1.0, 3.0, 1.0));
/// ```
#[must_use]
pub fn square_tail_power(set: &PointSet<[f64; 2]>) -> ByAxis {
    let weight = |j: usize| set.weights.get(j).copied().unwrap_or(1.0);
    // Exact sums, so that the result is exactly 1 for distinct coordinates.
    let mut squares = ExactSum::default();
    (0..set.len()).for_each(|j| squares.add(weight(j) * weight(j)));
    let squares = squares.value();
    if squares <= 0.0 {
        return ByAxis::default();
    }
    let groups = [0, 1].map(|axis| groups(&set.points, axis));
    let [u, v] = groups.each_ref().map(|groups| mean_power(groups, squares, weight));
    let pairs: Vec<[usize; 2]> = groups[0].iter().zip(&groups[1]).map(|(u, v)| [*u, *v]).collect();
    ByAxis { off: mean_power(&pairs, squares, weight), u, v }
}

/// Returns the number of the coordinate of every point; equal coordinates have equal numbers.
fn groups(points: &[[f64; 2]], axis: usize) -> Vec<usize> {
    let x = |j: usize| points[j][axis];
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_unstable_by(|&a, &b| x(a).total_cmp(&x(b)));
    let mut groups = vec![0; points.len()];
    let mut group = 0;
    for pair in order.windows(2) {
        group += usize::from(x(pair[1]) - x(pair[0]) > SAME_COORDINATE);
        groups[pair[1]] = group;
    }
    // The last coordinates can equal the first ones modulo 1.
    if let (Some(&first), Some(&last)) = (order.first(), order.last())
        && x(first) + 1.0 - x(last) <= SAME_COORDINATE
    {
        groups.iter_mut().filter(|g| **g == group).for_each(|g| *g = 0);
    }
    groups
}

/// Returns the sum over the groups of the squared sums of weights, divided by `squares`.
fn mean_power<G: Ord>(groups: &[G], squares: f64, weight: impl Fn(usize) -> f64) -> f64 {
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_unstable_by(|&a, &b| groups[a].cmp(&groups[b]).then(a.cmp(&b)));
    let mut sum = ExactSum::default();
    for group in order.chunk_by(|&a, &b| groups[a] == groups[b]) {
        sum.add(group.iter().map(|&j| weight(j)).sum::<f64>().powi(2));
    }
    sum.value() / squares
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::PointSet;
    use sphvar_sh::{ByAxis, TailClasses};

    use super::{SAME_COORDINATE, square_tail_power};

    /// Returns the mean power by the definition, summed over all pairs.
    fn by_pairs(set: &PointSet<[f64; 2]>) -> ByAxis {
        let w = |j: usize| set.weights.get(j).copied().unwrap_or(1.0);
        let same = |a: f64, b: f64| {
            let apart = (a - b).abs();
            apart.min(1.0 - apart) <= SAME_COORDINATE
        };
        let (mut sums, mut squares) = ([0.0; 3], 0.0);
        for (j, p) in set.points.iter().enumerate() {
            squares += w(j) * w(j);
            for (k, q) in set.points.iter().enumerate() {
                let [u, v] = [same(p[0], q[0]), same(p[1], q[1])];
                for (sum, is_same) in sums.iter_mut().zip([u && v, u, v]) {
                    *sum += if is_same { w(j) * w(k) } else { 0.0 };
                }
            }
        }
        ByAxis::from_fn(|class| sums[class] / squares)
    }

    #[test]
    fn groups_are_those_of_all_pairs() {
        let point = |j: usize| [0.754_877, 0.569_840].map(|a: f64| (a * j as f64).fract());
        let scattered: Vec<_> = (0..40).map(point).collect();
        // A grid of 6 x 4 with a shift whose sums round differently, across the edges.
        let shift = |x: f64, s: f64| (x + s).fract();
        let cell = |j: usize| [shift((j % 6) as f64 / 6.0, 0.9), shift((j / 6) as f64 / 4.0, 0.31)];
        let grid: Vec<_> = (0..24).map(cell).collect();
        let below = 1.0 - f64::EPSILON / 2.0;
        let mut hostile = [&*grid, &*scattered, &grid[3..9]].concat();
        hostile.extend([[0.0, below], [below, 0.0], [0.0; 2], [below; 2], [0.0, 0.5]]);
        // Close but distinct coordinates.
        hostile.extend((0..4).map(|j| [0.2 + 1e-11 * f64::from(j), 0.2]));
        let weights: Vec<f64> = (0..hostile.len()).map(|j| (j * 7 % 11) as f64 - 3.0).collect();
        let tiny: Vec<f64> = weights.iter().map(|w| 1e-9 * w).collect();
        let set = |points: &[[f64; 2]], weights: &[f64]| PointSet {
            points: points.to_vec(),
            weights: weights.to_vec(),
        };
        for set in [
            set(&scattered, &[]),
            set(&grid, &[]),
            set(&hostile, &[]),
            set(&hostile, &weights),
            set(&hostile, &tiny),
            set(&[[0.3, 0.4]; 30], &[]),
            set(&[[0.0; 2]], &[]),
        ] {
            let (got, expected) = (square_tail_power(&set), by_pairs(&set));
            for class in 0..3 {
                let (a, b) = (got.get(class), expected.get(class));
                assert!((a - b).abs() <= 1e-12 * b.max(1.0), "{set:?}: {got:?}, {expected:?}");
            }
        }
        assert_eq!(square_tail_power(&set(&scattered, &[])), ByAxis::all(1.0));
        assert_eq!(square_tail_power(&set(&grid, &[])), ByAxis { off: 1.0, u: 4.0, v: 6.0 });
        assert_eq!(square_tail_power(&set(&[], &[])), ByAxis::all(0.0));
        assert_eq!(square_tail_power(&set(&grid[..2], &[0.0; 2])), ByAxis::all(0.0));
    }
}
