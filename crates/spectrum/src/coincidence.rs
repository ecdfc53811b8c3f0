use std::collections::BTreeMap;

use glam::DVec3;
use sphvar_sh::ByParity;

use crate::ExactSum;

/// Maximum distance, 1.9e-6, at which two unit vectors count as the same direction. It covers the
/// rounding of coordinates to single precision or to six digits, and the residual asymmetry of
/// iterative optimization.
///
/// Points this close add coherently up to degrees near `1/SAME_DIRECTION` = 500,000. An integrand
/// with jumps has a fraction `lmax/500,000` of its energy beyond lmax above that degree. A fraction
/// `N 1e-12` of N independent points is this close by chance.
const SAME_DIRECTION: f64 = 16.0 * (f32::EPSILON as f64);

/// Three directions in general position. Points with nearly equal `|axis . x|` for all three lie on
/// at most four lines through the origin.
const AXES: [DVec3; 3] = [
    DVec3::new(0.531_287_412_913, 0.270_936_517_241, 0.802_701_348_077),
    DVec3::new(-0.718_530_931_347, 0.636_414_871_093, 0.280_611_236_719),
    DVec3::new(0.362_947_150_531, 0.839_226_517_853, -0.405_070_911_337),
];

/// Callback for the points of a line, each with whether it is opposite to the first one.
type Visitor<'a> = dyn FnMut(&[(usize, bool)]) + 'a;

/// Returns the mean power of a point set at high degrees, for even and for odd degrees. Empty
/// `weights` mean unit weights.
///
/// Two points contribute `2 w_j w_k P_l(x_j . x_k)/sum w^2` to the power of degree l. The average
/// of this over degrees vanishes unless the points coincide (`P_l = 1`) or are antipodal
/// (`P_l = (-1)^l`). With the sums `W+` and `W-` of weights on the two ends of a line through the
/// origin,
///
/// ```text
/// even: sum_lines (W+ + W-)^2 / sum w^2,    odd: sum_lines (W+ - W-)^2 / sum w^2
/// ```
///
/// Both are exactly 1 if no two points share a line, and exactly 2 and 0 for an antipodal set with
/// equal weights. Points at a distance of at most 1.9e-6 count as coincident, so that sets in
/// single precision keep their symmetry. On the hemisphere the even value applies; odd degrees do
/// not exist.
///
/// # Panics
///
/// Panics if `weights` is neither empty nor of the same length as `points`.
///
/// # Performance
///
/// O(N log N), for a sort.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_spectrum::tail_power;
///
/// let poles = tail_power(&[DVec3::Z, DVec3::NEG_Z], &[]);
/// assert_eq!((poles.even, poles.odd), (2.0, 0.0));
/// ```
#[must_use]
pub fn tail_power(points: &[DVec3], weights: &[f64]) -> ByParity {
    assert!(weights.is_empty() || weights.len() == points.len(), "one weight per point");
    let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
    // Exact sums, so that the result is exactly 1 for distinct points.
    let mut squares = ExactSum::default();
    let mut sums = ByParity::<ExactSum>::default();
    for_each_line(points, (0..points.len()).collect(), &AXES, &mut |line| {
        let mut ends = [0.0; 2];
        for &(k, is_opposite) in line {
            let w = weight(k);
            ends[usize::from(is_opposite)] += w;
            squares.add(w * w);
        }
        sums.even.add((ends[0] + ends[1]).powi(2));
        sums.odd.add((ends[0] - ends[1]).powi(2));
    });
    let squares = squares.value();
    if squares > 0.0 { sums.map(|sum| sum.value() / squares) } else { ByParity::default() }
}

/// The tail power of a sample of the directions of a set, which the sets of disjoint points add to.
///
/// The sphere is divided into cells with a random number each, and the sample has the points in and
/// near the cells with the smallest numbers, as few as needed. It depends on the points only, and
/// points that coincide or are antipodal are in it together.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TailSample {
    /// The cells are a share `2^-level` of all.
    level: u32,
    /// By the bits of the direction, one of each antipodal pair.
    lines: BTreeMap<[u64; 3], Ends>,
}

/// The sums of weights at a direction and at its antipode, and the sum of their squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Ends {
    sums: [f64; 2],
    squares: f64,
}

/// The maximum number of lines of a sample.
const MAX_LINES: usize = 1 << 13;
/// The number of cells along a unit of length.
const CELLS: f64 = (1 << 15) as f64;

impl TailSample {
    /// The memory of a sample, with that of the nodes of its map.
    pub(crate) const MAX_BYTES: usize = 2 * MAX_LINES * (size_of::<([u64; 3], Ends)>() + 16);

    /// Returns the sample of points; empty `weights` mean unit weights.
    pub(crate) fn of(points: &[DVec3], weights: &[f64]) -> Self {
        let mut sample = Self::default();
        for (k, &point) in points.iter().enumerate() {
            if is_near(point, sample.level) {
                let weight = weights.get(k).copied().unwrap_or(1.0);
                let (line, is_opposite) = line_of(point);
                let ends = sample.lines.entry(line).or_default();
                ends.sums[usize::from(is_opposite)] += weight;
                ends.squares += weight * weight;
                sample.limit();
            }
        }
        sample
    }

    /// Adds the sample of other points.
    pub(crate) fn merge(&mut self, other: Self) {
        self.raise(other.level);
        for (line, theirs) in other.lines {
            if is_near(direction(line), self.level) {
                let ends = self.lines.entry(line).or_default();
                ends.sums[0] += theirs.sums[0];
                ends.sums[1] += theirs.sums[1];
                ends.squares += theirs.squares;
            }
        }
        self.limit();
    }

    /// Multiplies all weights.
    pub(crate) fn scale(&mut self, factor: f64) {
        for ends in self.lines.values_mut() {
            ends.sums.iter_mut().for_each(|sum| *sum *= factor);
            ends.squares *= factor * factor;
        }
    }

    /// Returns [`tail_power`] of the sample; NaN if it is empty and the set is not.
    pub(crate) fn power(&self) -> ByParity {
        let points: Vec<DVec3> = self.lines.keys().map(|line| direction(*line)).collect();
        let ends: Vec<&Ends> = self.lines.values().collect();
        let mut squares = ExactSum::default();
        let mut sums = ByParity::<ExactSum>::default();
        let mut has_lines = false;
        for_each_line(&points, (0..points.len()).collect(), &AXES, &mut |line| {
            // Points near a cell belong to the line of a point in it.
            let first = line.iter().map(|(k, _)| *k).min();
            if !first.is_some_and(|k| is_in(cell(points[k].abs()), self.level)) {
                return;
            }
            has_lines = true;
            let mut totals = [0.0; 2];
            for &(k, is_opposite) in line {
                totals[usize::from(is_opposite)] += ends[k].sums[0];
                totals[usize::from(!is_opposite)] += ends[k].sums[1];
                squares.add(ends[k].squares);
            }
            sums.even.add((totals[0] + totals[1]).powi(2));
            sums.odd.add((totals[0] - totals[1]).powi(2));
        });
        let squares = squares.value();
        match has_lines {
            false if self.level > 0 => ByParity::both(f64::NAN),
            _ if squares > 0.0 => sums.map(|sum| sum.value() / squares),
            _ => ByParity::default(),
        }
    }

    /// Reduces the sample to its maximum size.
    fn limit(&mut self) {
        while self.lines.len() > MAX_LINES && self.level < u64::BITS - 1 {
            self.raise(self.level + 1);
        }
    }

    fn raise(&mut self, level: u32) {
        if level > self.level {
            self.level = level;
            self.lines.retain(|line, _| is_near(direction(*line), level));
        }
    }
}

/// Returns the line of a direction, and whether the direction is its second end.
fn line_of(point: DVec3) -> ([u64; 3], bool) {
    let is_opposite = [point.z, point.y, point.x].into_iter().find(|x| *x != 0.0) < Some(0.0);
    let end = if is_opposite { -point } else { point };
    // Adding 0 turns -0 to 0.
    (end.to_array().map(|x| (x + 0.0).to_bits()), is_opposite)
}

fn direction(line: [u64; 3]) -> DVec3 {
    DVec3::from_array(line.map(f64::from_bits))
}

/// Returns the cell of the absolute coordinates of a direction, which antipodes share.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the cast saturates, and coordinates are below 2"
)]
fn cell(size: DVec3) -> [i32; 3] {
    size.to_array().map(|x| (x * CELLS).floor() as i32)
}

/// Returns whether a cell is in samples of this level.
fn is_in(cell: [i32; 3], level: u32) -> bool {
    // The finalizer of SplitMix64; coordinates of cells are from -1 to 2^15.
    let packed =
        cell.into_iter().fold(0, |key: u64, x| (key << 20) | u64::from((x + 1).unsigned_abs()));
    let mut hash = packed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    level == 0 || (hash ^ (hash >> 31)) >> (u64::BITS - level) == 0
}

/// Returns whether the cell of a direction, or one that a coincident direction may be in, is in
/// samples of this level.
fn is_near(point: DVec3, level: u32) -> bool {
    if level == 0 {
        return true;
    }
    // Points of a line are this close to its first one, and to each other up to twice that.
    const NEAR: DVec3 = DVec3::splat(2.0 * SAME_DIRECTION);
    let size = point.abs();
    let (low, high) = (cell(size - NEAR), cell(size + NEAR));
    let ends = |i: usize| low[i]..=high[i];
    ends(0).any(|x| ends(1).any(|y| ends(2).any(|z| is_in([x, y, z], level))))
}

/// Calls `f` with the points of each line through the origin.
fn for_each_line(points: &[DVec3], members: Vec<usize>, axes: &[DVec3], f: &mut Visitor<'_>) {
    let Some((axis, rest)) = axes.split_first() else {
        return;
    };
    let mut keyed: Vec<(f64, usize)> =
        members.into_iter().map(|k| (axis.dot(points[k]).abs(), k)).collect();
    keyed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Points of one line have keys that differ by rounding.
    for run in keyed.chunk_by(|a, b| b.0 - a.0 <= SAME_DIRECTION) {
        match run {
            [(_, single)] => f(&[(*single, false)]),
            _ if rest.is_empty() || run.len() == 2 => gather(points, run, f),
            _ => for_each_line(points, run.iter().map(|r| r.1).collect(), rest, f),
        }
    }
}

/// Groups the points of a run, sorted by key, into lines by pairwise comparison.
fn gather(points: &[DVec3], run: &[(f64, usize)], f: &mut Visitor<'_>) {
    let mut is_taken = vec![false; run.len()];
    let mut line = Vec::new();
    for i in 0..run.len() {
        if is_taken[i] {
            continue;
        }
        let (key, first) = run[i];
        line.clear();
        line.push((first, false));
        let near = (i + 1..run.len()).take_while(|&j| run[j].0 - key <= SAME_DIRECTION);
        for j in near {
            let (a, b) = (points[first], points[run[j].1]);
            let is_opposite = a.dot(b) < 0.0;
            let apart = if is_opposite { (a + b).length() } else { (a - b).length() };
            if !is_taken[j] && apart <= SAME_DIRECTION {
                is_taken[j] = true;
                line.push((run[j].1, is_opposite));
            }
        }
        f(&line);
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use sphvar_sh::ByParity;

    use super::{SAME_DIRECTION, tail_power};

    /// Returns the tail power by the definition, summed over all pairs.
    fn by_pairs(points: &[DVec3], weights: &[f64]) -> ByParity {
        let w = |k: usize| weights.get(k).copied().unwrap_or(1.0);
        let mut sum = ByParity::both(0.0);
        let mut squares = 0.0;
        for (j, &x) in points.iter().enumerate() {
            squares += w(j) * w(j);
            for (k, &y) in points.iter().enumerate() {
                let same = f64::from((x - y).length() <= SAME_DIRECTION);
                let opposite = f64::from((x + y).length() <= SAME_DIRECTION);
                sum.even += w(j) * w(k) * (same + opposite);
                sum.odd += w(j) * w(k) * (same - opposite);
            }
        }
        sum.map(|s| s / squares)
    }

    fn spiral(n: usize) -> Vec<DVec3> {
        let point = |k: usize| {
            let z = 1.0 - (2 * k + 1) as f64 / n as f64;
            let (s, c) = (2.4 * k as f64).sin_cos();
            DVec3::new(c * (1.0 - z * z).sqrt(), s * (1.0 - z * z).sqrt(), z).normalize()
        };
        (0..n).map(point).collect()
    }

    #[test]
    fn lines_are_those_of_all_pairs() {
        let rotation = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(1.1);
        let base = spiral(40);
        let rotated = |p: &DVec3| (rotation * *p).normalize();
        let back = |p: &DVec3| (rotation.inverse() * rotated(p)).normalize();
        // Points repeated up to rounding, antipodes, and points of the equator and the poles.
        let mut hostile = base.clone();
        hostile.extend(base.iter().step_by(3).map(back));
        hostile.extend(base.iter().step_by(4).map(|p| -back(p)));
        hostile.extend([DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::Z, DVec3::NEG_Z, DVec3::Z]);
        // Close but distinct points.
        hostile.extend((1..6).map(|k| DVec3::new(1e-5 * f64::from(k), 1.0, 0.0).normalize()));
        let weights: Vec<f64> = (0..hostile.len()).map(|k| ((k * 7 % 11) as f64) - 3.0).collect();
        let sets: [(&str, &[DVec3], &[f64]); 5] = [
            ("distinct", &base, &[]),
            ("hostile", &hostile, &[]),
            ("weighted", &hostile, &weights),
            ("repeated", &[DVec3::X; 50], &[]),
            ("one", &[DVec3::X], &[]),
        ];
        for (name, points, weights) in sets {
            let (got, expected) = (tail_power(points, weights), by_pairs(points, weights));
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * b.abs().max(1.0);
            assert!(
                near(got.even, expected.even) && near(got.odd, expected.odd),
                "{name}: {got:?}, by pairs {expected:?}"
            );
        }
        assert_eq!(tail_power(&base, &[]), ByParity::both(1.0));
        assert_eq!(tail_power(&[], &[]), ByParity::both(0.0));
    }

    /// An octahedron with its coordinates rounded to six digits and to single precision.
    #[test]
    fn rounded_sets_keep_their_symmetry() {
        let rotation = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(1.1);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        let exact = axes.map(|p| rotation * p);
        let single = exact.map(|p| (p * 3.0).as_vec3().as_dvec3().normalize());
        // Rounded on one side only, so that antipodes are not exact either.
        let digits = |x: f64| (x * 1e6).floor() / 1e6;
        let decimal = exact.map(|p| DVec3::new(digits(p.x), digits(p.y), digits(p.z)).normalize());
        for points in [exact, single, decimal] {
            assert_eq!(tail_power(&points, &[]), ByParity { even: 2.0, odd: 0.0 });
        }
    }

    #[test]
    fn many_coincident_points_are_handled_efficiently() {
        let mut points = vec![DVec3::X; 300_000];
        points.extend(vec![DVec3::NEG_X; 100_000]);
        let got = tail_power(&points, &[]);
        // (3e5 +- 1e5)^2/4e5.
        assert_eq!(got, ByParity { even: 4e5, odd: 1e5 });
    }
}
