use std::f64::consts::PI;

use sphvar_samplers::{PointSet, Progress, Stopped};
use sphvar_sh::{CompensatedSum, Frequencies};

use super::{
    MAX_POINTS_OF_STAR_DISCREPANCY, l2_star_discrepancy, star_discrepancy,
    wraparound_l2_discrepancy,
};
use crate::{SpectrumAccumulator, SquareResolution, accumulate_square};

type Points = Vec<[f64; 2]>;

/// Scattered, regular and repeated points, points on the edges and in one row.
fn sets() -> Vec<Points> {
    let scattered = |n: usize| -> Points {
        (0..n)
            .map(|j| [0.754_877_666, 0.569_840_291].map(|a: f64| (a * j as f64 + 0.1).fract()))
            .collect()
    };
    let grid = (0..30).map(|j| [f64::from(j % 5) / 5.0, f64::from(j / 5) / 6.0]).collect();
    let below = 1.0 - f64::EPSILON / 2.0;
    let edges = vec![[0.0, below], [below, 0.0], [0.0; 2], [below; 2], [0.5, 0.0], [0.5, below]];
    let row = (0..17).map(|j| [f64::from(j) / 20.0, 0.7]).collect();
    let repeated = [scattered(9), scattered(5), vec![[0.25, 0.5]; 6]].concat();
    vec![scattered(1), scattered(2), scattered(61), grid, edges, row, repeated, vec![[below; 2]]]
}

/// Returns the supremum over all boxes whose sides are coordinates of points or 1.
fn star_by_definition(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let sides = |axis: usize| points.iter().map(move |p| p[axis]).chain([1.0]);
    let boxes = sides(0).flat_map(|u| sides(1).map(move |v| (u, v)));
    let deviation = |(u, v): (f64, f64)| {
        let closed = points.iter().filter(|p| p[0] <= u && p[1] <= v).count() as f64;
        let open = points.iter().filter(|p| p[0] < u && p[1] < v).count() as f64;
        (closed / n - u * v).max(u * v - open / n)
    };
    boxes.map(deviation).fold(0.0, f64::max)
}

/// Returns a sum over all ordered pairs of points; a plain sum would lose five digits.
fn over_pairs(points: &[[f64; 2]], f: impl Fn(&[f64; 2], &[f64; 2]) -> f64) -> f64 {
    let f = &f;
    let pairs = points.iter().flat_map(|p| points.iter().map(move |q| f(p, q)));
    pairs.collect::<CompensatedSum>().value()
}

/// Returns the sum of Warnock over all pairs.
fn l2_by_pairs(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let single = |p: &[f64; 2]| (1.0 - p[0] * p[0]) * (1.0 - p[1] * p[1]);
    let pair = |p: &[f64; 2], q: &[f64; 2]| (1.0 - p[0].max(q[0])) * (1.0 - p[1].max(q[1]));
    let pairs = over_pairs(points, pair);
    (1.0 / 9.0 - points.iter().map(single).sum::<f64>() / (2.0 * n) + pairs / (n * n)).sqrt()
}

/// Returns the sum of Hickernell over all pairs.
fn wraparound_by_pairs(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let kernel = |x: f64| 1.5 - x.abs() * (1.0 - x.abs());
    let pair = |p: &[f64; 2], q: &[f64; 2]| kernel(p[0] - q[0]) * kernel(p[1] - q[1]);
    let pairs = over_pairs(points, pair);
    (pairs / (n * n) - 16.0 / 9.0).sqrt()
}

#[test]
fn discrepancies_are_those_of_the_definitions() {
    for points in sets() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-13;
        let star = star_discrepancy(&points, &()).unwrap().unwrap();
        assert!(close(star, star_by_definition(&points)), "{points:?}: {star}");
        let l2 = l2_star_discrepancy(&points, &()).unwrap().unwrap();
        assert!(close(l2, l2_by_pairs(&points)), "{points:?}: {l2}, {}", l2_by_pairs(&points));
        assert!(l2 <= star, "{points:?}");
        let wraparound = wraparound_l2_discrepancy(&points, &()).unwrap().unwrap();
        let expected = wraparound_by_pairs(&points);
        assert!(close(wraparound, expected), "{points:?}: {wraparound}, {expected}");
    }
}

/// The mean of the squared deviation over boxes, by the midpoint rule, whose error for 61 points is
/// below 2 %.
#[test]
fn the_l2_discrepancy_is_a_mean_over_boxes() {
    let points = sets().swap_remove(2);
    let side = 400;
    let middle = |i: usize| (i as f64 + 0.5) / side as f64;
    let deviation = |u: f64, v: f64| {
        let inside = points.iter().filter(|p| p[0] < u && p[1] < v).count();
        (inside as f64 / points.len() as f64 - u * v).powi(2)
    };
    let boxes = (0..side).flat_map(|i| (0..side).map(move |j| (middle(i), middle(j))));
    let mean = boxes.map(|(u, v)| deviation(u, v)).sum::<f64>() / (side * side) as f64;
    let got = l2_star_discrepancy(&points, &()).unwrap().unwrap();
    assert!((got / mean.sqrt() - 1.0).abs() < 0.02, "{got}, {mean}");
}

/// The wrap-around discrepancy is a sum over frequencies, with mean powers beyond the last ones.
#[test]
fn the_wraparound_discrepancy_is_a_sum_over_the_spectrum() {
    let bands = Frequencies::new(100).unwrap().with_axes(4000).unwrap();
    for points in sets() {
        let empty = SpectrumAccumulator::of_square(bands.clone(), points.len()).unwrap();
        let resolution = SquareResolution::new(bands.clone());
        let set = [PointSet::new(points.clone())];
        let sums = accumulate_square(&set.as_slice(), &resolution, 0..1, &empty, &()).unwrap();
        let spectrum = sums.finish().unwrap();
        let weight = |k: i32| {
            let square = (PI * f64::from(k)).powi(2);
            if k == 0 { 4.0 / 3.0 } else { 0.5 / square }
        };
        // The sum of r(k) over k != 0 is 1/6.
        let (mut sum, mut beyond) = (0.0, [1.0 / 36.0, 2.0 / 9.0, 2.0 / 9.0]);
        for (band, p, _) in spectrum.rows().skip(1) {
            let [k1, k2] = bands.frequency(band);
            let both = 2.0 * weight(k1) * weight(k2);
            sum += both * p;
            beyond[sphvar_sh::Bands::tail_class(&bands, band)] -= both;
        }
        let tail = spectrum.tail();
        sum += beyond[0] * tail.off + beyond[1] * tail.u + beyond[2] * tail.v;
        let expected = (sum / points.len() as f64).sqrt();
        let got = wraparound_l2_discrepancy(&points, &()).unwrap().unwrap();
        // The power off the axes beyond kmax differs from its mean near the axes.
        assert!((got / expected - 1.0).abs() < 0.02, "{points:?}: {got}, {expected}");
    }
}

/// A shift modulo 1 changes the star discrepancy, but not the wrap-around discrepancy.
#[test]
fn the_wraparound_discrepancy_is_invariant_under_shifts() {
    let points = sets().swap_remove(6);
    let shifted: Points =
        points.iter().map(|p| [(p[0] + 0.37).fract(), (p[1] + 0.81).fract()]).collect();
    let both = |f: fn(&[[f64; 2]]) -> f64| [f(&points), f(&shifted)];
    let [a, b] = both(|points| wraparound_l2_discrepancy(points, &()).unwrap().unwrap());
    assert!((a - b).abs() < 1e-14, "{a}, {b}");
    let [a, b] = both(|points| star_discrepancy(points, &()).unwrap().unwrap());
    assert!((a - b).abs() > 1e-3, "{a}, {b}");
}

/// The discrepancies of a regular grid in closed form: D = 1/n for the points (i/n, j/n) up to the
/// corner of the last cell.
#[test]
fn large_sets_keep_their_accuracy() {
    let side = 300;
    let x = |i: usize| i as f64 / side as f64;
    let grid: Points = (0..side * side).map(|j| [x(j % side), x(j / side)]).collect();
    // Sums over pairs of a product grid are products of sums over its sides.
    let n = side as f64;
    let kernel = |i: usize| 1.5 - x(i) * (1.0 - x(i));
    let row: f64 = (0..side).map(kernel).sum::<f64>() / n;
    // row - 4/3 is 1/(6 n^2): the difference of squares without cancellation.
    let exact = ((row - 4.0 / 3.0) * (row + 4.0 / 3.0)).sqrt();
    let closed_form = (1.0 / (6.0 * n * n) * (8.0 / 3.0 + 1.0 / (6.0 * n * n))).sqrt();
    assert!((exact / closed_form - 1.0).abs() < 1e-8);
    let got = wraparound_l2_discrepancy(&grid, &()).unwrap().unwrap();
    assert!((got / closed_form - 1.0).abs() < 1e-9, "{got}, {closed_form}");
    let too_many = vec![[0.5; 2]; MAX_POINTS_OF_STAR_DISCREPANCY + 1];
    let unavailable = star_discrepancy(&too_many, &()).unwrap().unwrap_err();
    assert!(unavailable.reason.contains("50000"), "{unavailable}");
    assert!(l2_star_discrepancy(&[], &()).unwrap().is_err());
    assert!(star_discrepancy(&[], &()).unwrap().is_err());
}

#[test]
fn long_sums_can_be_stopped() {
    #[derive(Debug)]
    struct Interrupted;
    impl Progress for Interrupted {
        fn tick(&self, _work: f64) -> Result<(), Stopped> {
            Err(Stopped)
        }
    }
    let points = vec![[0.5; 2]; 20_000];
    assert!(star_discrepancy(&points, &Interrupted).is_err());
    assert!(l2_star_discrepancy(&points, &Interrupted).is_err());
    assert!(wraparound_l2_discrepancy(&points, &Interrupted).is_err());
}
