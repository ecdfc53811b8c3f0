//! Tests of properties of point sets of the square: strata, nets and lattices.
//!
//! A coordinate that is below a multiple of 1/n by no more than its rounding, 2^-52, counts as that
//! multiple, unless n is a power of two: a third is not a floating-point number.
//!
//! ```
//! use sphvar_samplers::{Purpose, SquarePattern, Streams, checks};
//! let points = |pattern: SquarePattern| {
//!     let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
//!     Ok::<_, sphvar_samplers::Error>(pattern.build(64)?.sample(&mut rng)?.points)
//! };
//! assert_eq!(checks::net_parameter(&points(SquarePattern::Pmj02)?), Some(0));
//! assert!(checks::is_latin_hypercube(&points(SquarePattern::LatinHypercube)?));
//! assert!(checks::is_stratified(&points(SquarePattern::JitteredSquare)?, 8, 8));
//! assert_eq!(checks::lattice(&points(SquarePattern::R2)?), None);
//! # Ok::<(), sphvar_samplers::Error>(())
//! ```

use crate::Lattice;
use crate::space::internal::Point as _;

/// Returns whether each of `rows` x `columns` equal rectangles of the square, rows in u, holds
/// exactly one point; false for no points.
#[must_use]
pub fn is_stratified(points: &[[f64; 2]], rows: usize, columns: usize) -> bool {
    let n = points.len();
    n > 0 && rows.checked_mul(columns) == Some(n) && are_balanced(points, rows, columns, 1)
}

/// Returns whether each of N equal strips in u and each of N in v holds exactly one of the N points;
/// false for no points.
#[must_use]
pub fn is_latin_hypercube(points: &[[f64; 2]]) -> bool {
    is_stratified(points, points.len(), 1) && is_stratified(points, 1, points.len())
}

/// Returns the smallest t for which 2^m points are a (t, m, 2)-net in base 2: for which every elementary
/// interval `[i/2^a, (i+1)/2^a) x [j/2^b, (j+1)/2^b)` with a + b = m - t holds 2^t points. `None` if
/// the number of points is not a power of two, or if a point is outside the square.
///
/// Cost: at most `m^2/2` passes through the points, m + 1 for t = 0.
///
/// # References
///
/// H. Niederreiter, "Point sets and sequences with small discrepancy", Monatsh. Math. 104 (1987).
#[must_use]
pub fn net_parameter(points: &[[f64; 2]]) -> Option<u32> {
    if !points.len().is_power_of_two() {
        return None;
    }
    let m = points.len().trailing_zeros();
    let is_net =
        |t: u32| (0..=m - t).all(|a| are_balanced(points, 1 << a, 1 << (m - t - a), 1 << t));
    (0..=m).find(|&t| is_net(t))
}

/// Returns the lattice of which the points are a shift, in any order: the lattice of their
/// differences to one of them, if those are closed under addition modulo 1 to within rounding.
/// `None` for no points, repeated points, points outside the square, and more than 2^32 - 1 points.
///
/// The differences of N points that are a lattice are multiples of 1/N; they must match these within
/// 1e-3/N.
#[must_use]
pub fn lattice(points: &[[f64; 2]]) -> Option<Lattice> {
    let n = u32::try_from(points.len()).ok().filter(|&n| n > 0)?;
    if !points.iter().all(|p| p.is_valid()) {
        return None;
    }
    let first = points[0];
    let multiples: Vec<[u32; 2]> = points
        .iter()
        .map(|p| Some([multiple_of_nth(p[0] - first[0], n)?, multiple_of_nth(p[1] - first[1], n)?]))
        .collect::<Option<_>>()?;
    let columns = u32::try_from(multiples.iter().filter(|p| p[0] == 0).count()).ok()?;
    if n % columns != 0 {
        return None;
    }
    let rows = n / columns;
    // The point with the smallest positive u, if u has more than one value.
    let skew = multiples.iter().find(|p| rows == 1 || p[0] == columns)?[1] % rows;
    let lattice = Lattice::from_normal_form(rows, columns, if rows == 1 { 0 } else { skew });
    let mut is_taken = vec![false; n as usize];
    for point in multiples {
        let index = lattice.index_of(point)?;
        if std::mem::replace(&mut is_taken[index], true) {
            return None;
        }
    }
    Some(lattice)
}

/// Returns k with `x = k/n` modulo 1, if there is one.
fn multiple_of_nth(x: f64, n: u32) -> Option<u32> {
    let scaled = x.rem_euclid(1.0) * f64::from(n);
    let nearest = scaled.round();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to n")]
    let k = nearest as u32;
    ((scaled - nearest).abs() < 1e-3).then_some(if k == n { 0 } else { k })
}

/// Returns whether each of `rows` x `columns` equal rectangles holds `each` points.
fn are_balanced(points: &[[f64; 2]], rows: usize, columns: usize, each: u32) -> bool {
    if !points.iter().all(|p| p.is_valid()) {
        return false;
    }
    let mut counts = vec![0_u32; rows * columns];
    points.iter().for_each(|p| counts[part(p[0], rows) * columns + part(p[1], columns)] += 1);
    counts.iter().all(|&count| count == each)
}

/// Returns the index of the one of `n` equal parts of [0, 1) that contains `x`.
fn part(x: f64, n: usize) -> usize {
    let rounding = if n.is_power_of_two() { 1.0 } else { 1.0 + f64::EPSILON };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 <= x < 1")]
    let index = (x * n as f64 * rounding) as usize;
    index.min(n - 1)
}

#[cfg(test)]
mod tests {
    use super::{is_latin_hypercube, is_stratified, lattice, net_parameter, part};
    use crate::{Lattice, Purpose, SquarePattern, Streams};

    /// Every i/n is in part i, whatever its rounding.
    #[test]
    fn multiples_of_the_width_are_in_the_parts_that_they_begin() {
        for n in 1..3000 {
            for i in 0..n {
                assert_eq!(part(i as f64 / n as f64, n), i, "{i}/{n}");
            }
            assert_eq!(part(1.0 - f64::EPSILON / 2.0, n), n - 1);
        }
    }

    fn sample(pattern: &SquarePattern, n: usize) -> Vec<[f64; 2]> {
        let mut rng = Streams::new(2, Purpose::Pattern, n).realization(0);
        pattern.build(n).unwrap().sample(&mut rng).unwrap().points
    }

    /// The definitions: a count of the points of each rectangle, by comparisons of coordinates.
    #[test]
    fn strata_and_nets_match_their_definitions() {
        let holds = |points: &[[f64; 2]], [rows, columns]: [usize; 2], each: usize| {
            let within = |x: f64, i: usize, n: usize| {
                i as f64 / n as f64 <= x && x < (i + 1) as f64 / n as f64
            };
            (0..rows).all(|i| {
                (0..columns).all(|j| {
                    let inside = |p: &&[f64; 2]| within(p[0], i, rows) && within(p[1], j, columns);
                    points.iter().filter(inside).count() == each
                })
            })
        };
        for pattern in SquarePattern::ALL {
            for n in [1, 2, 4, 8, 16, 64, 6, 9, 15, 36].map(|n| pattern.nearest_count(n)) {
                let points = sample(&pattern, n);
                for rows in (1..=n).filter(|rows| n % rows == 0) {
                    let got = is_stratified(&points, rows, n / rows);
                    assert_eq!(got, holds(&points, [rows, n / rows], 1), "{pattern} {n} {rows}");
                }
                let both = holds(&points, [n, 1], 1) && holds(&points, [1, n], 1);
                assert_eq!(is_latin_hypercube(&points), both, "{pattern} {n}");
                let m = n.trailing_zeros();
                let is_net = |t: &u32| {
                    (0..=m - t).all(|a| holds(&points, [1 << a, 1 << (m - t - a)], 1 << t))
                };
                let expected = n.is_power_of_two().then(|| (0..=m).find(is_net).unwrap());
                assert_eq!(net_parameter(&points), expected, "{pattern} {n}");
            }
        }
    }

    #[test]
    fn lattices_are_found_after_shifts_in_any_order() {
        let lattices = (1..9_u32).flat_map(|rows| {
            (1..7).flat_map(move |columns| {
                (0..rows).map(move |skew| Lattice::from_normal_form(rows, columns, skew))
            })
        });
        for expected in lattices {
            let n = expected.n_points();
            let shifted = |x: f64, by: f64| (x + by).fract();
            // 7 steps at a time pass through all points unless 7 divides their number.
            let order = (0..n).map(|j| if n % 7 == 0 { n - 1 - j } else { (7 * j + 3) % n });
            let mut points: Vec<[f64; 2]> = order
                .map(|j| expected.point(j))
                .map(|[u, v]| [shifted(u, 0.911), shifted(v, 1.0 - 1e-17)])
                .collect();
            assert_eq!(lattice(&points), Some(expected));
            // With one point elsewhere, or twice, the set is not closed under addition.
            if n > 2 {
                points[n / 2][1] = shifted(points[n / 2][1], 0.5 / n as f64);
                assert_eq!(lattice(&points), None, "{expected:?}");
                points[n / 2] = points[0];
                assert_eq!(lattice(&points), None, "{expected:?}");
            }
        }
        let repeated = [[0.0, 0.0], [0.0, 0.0]];
        assert_eq!((lattice(&[]), lattice(&repeated)), (None, None));
    }

    /// Sets that are multiples of 1/N are lattices exactly if sums of any two are among them.
    #[test]
    fn lattices_match_their_definition() {
        let n = 5;
        let mut found = 0;
        // All sets of five points on the grid of fifths with distinct u, the first at the origin.
        for code in 0..5_usize.pow(4) {
            let values = [0, code % 5, code / 5 % 5, code / 25 % 5, code / 125];
            let is_closed =
                (0..n).all(|i| (0..n).all(|j| values[(i + j) % n] == (values[i] + values[j]) % n));
            let points: Vec<_> = (0..n).map(|i| [i as f64 / 5.0, values[i] as f64 / 5.0]).collect();
            assert_eq!(lattice(&points).is_some(), is_closed, "{code}");
            found += usize::from(is_closed);
        }
        assert_eq!(found, 5);
    }

    #[test]
    fn points_outside_the_square_have_no_property() {
        for x in [f64::NAN, 1.0, -1e-300, f64::INFINITY] {
            assert_eq!(net_parameter(&[[0.5, x]]), None);
            assert!(!is_stratified(&[[x, 0.5]], 1, 1) && !is_latin_hypercube(&[[x, 0.5]]));
            assert!(lattice(&[[0.25, 0.5], [x, 0.5]]).is_none(), "{x}");
        }
        assert!(!is_latin_hypercube(&[]) && net_parameter(&[]).is_none());
        assert!(!is_stratified(&[[0.5; 2]], 0, 5) && !is_stratified(&[], 0, usize::MAX));
    }
}
