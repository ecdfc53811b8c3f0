//! The distribution of random sequential addition against plain dart throwing.

use rand::{Rng, RngExt};
use sphvar_samplers::DiskMode;

use super::{Point, disks, distance, sample, streams};

/// Random sequential addition by its definition: uniform candidates on the whole square, accepted if
/// no earlier point is near. It restarts after so long a run of rejections that the set must be
/// full.
fn throw_by_definition(is_wrapped: bool, n: usize, radius: f64, rng: &mut dyn Rng) -> Vec<Point> {
    const IN_VAIN: u32 = 200_000;
    loop {
        let mut points: Vec<Point> = Vec::with_capacity(n);
        let mut misses = 0;
        while misses < IN_VAIN {
            let candidate: Point = rng.random();
            if points.iter().all(|&p| distance(is_wrapped, p, candidate) >= radius) {
                points.push(candidate);
                misses = 0;
                if points.len() == n {
                    return points;
                }
            } else {
                misses += 1;
            }
        }
    }
}

const N_FIGURES: usize = 6;

/// Returns statistics of one set that a wrong distribution of the candidates would shift: for all
/// points the distance to the nearest point, its spread and pairs that nearly touch; for the last
/// eighth placed the distance to the nearest point; distances from the sides; close pairs among the
/// first third.
fn figures(is_wrapped: bool, points: &[Point], radius: f64) -> [f64; N_FIGURES] {
    let n = points.len();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let apart = |i: usize, j: usize| distance(is_wrapped, points[i], points[j]) / radius;
    let nearest_of: Vec<f64> = (0..n)
        .map(|i| (0..n).filter(|&j| j != i).map(|j| apart(i, j)).fold(f64::MAX, f64::min))
        .collect();
    let pairs = |len: usize, limit: f64| {
        let of = |i: usize| (0..i).filter(|&j| apart(i, j) < limit).count();
        (0..len).map(of).sum::<usize>() as f64 / n as f64
    };
    let nearest = mean(&nearest_of);
    let spread = mean(&nearest_of.iter().map(|d| (d - nearest).powi(2)).collect::<Vec<_>>());
    let sides: Vec<f64> = points.iter().flatten().map(|x| x.min(1.0 - x)).collect();
    let late = n - n.div_ceil(8);
    [
        nearest,
        spread,
        pairs(n, 1.1),
        mean(&nearest_of[late..]),
        mean(&sides),
        pairs(n.div_ceil(3), 1.5),
    ]
}

/// The distribution is that of plain dart throwing. Six statistics of 4 patterns are compared by the
/// difference of their means over independent sets in units of its standard error; all 24 are below
/// 4.35 with probability 1 - 24 * 1.36e-5 = 0.9997 for normal means.
#[test]
#[ignore = "statistics"]
fn the_distribution_matches_plain_dart_throwing() {
    const SETS: usize = 600;
    const LIMIT: f64 = 4.35;
    for is_wrapped in [true, false] {
        for (n, radius) in [(12, 0.73), (150, 0.79)] {
            let disks = disks(n, DiskMode::Exact, is_wrapped, Some(radius));
            let mean_and_error = |sets: &mut dyn FnMut(u64) -> Vec<Point>| {
                let all: Vec<[f64; N_FIGURES]> = (0..SETS as u64)
                    .map(|i| figures(is_wrapped, &sets(i), disks.distance()))
                    .collect();
                std::array::from_fn::<_, N_FIGURES, _>(|k| {
                    let mean = all.iter().map(|f| f[k]).sum::<f64>() / SETS as f64;
                    let squares: f64 = all.iter().map(|f| (f[k] - mean).powi(2)).sum();
                    (mean, squares / (SETS * (SETS - 1)) as f64)
                })
            };
            let fast = mean_and_error(&mut |i| sample(&disks, i));
            let slow = mean_and_error(&mut |i| {
                let rng = &mut streams(n).realization(1 << 32 | i);
                throw_by_definition(is_wrapped, n, disks.distance(), rng)
            });
            for (k, (&(a, var_a), &(b, var_b))) in fast.iter().zip(&slow).enumerate() {
                let z = (a - b) / (var_a + var_b).sqrt();
                assert!(z.abs() < LIMIT, "{n} figure {k}: {a} against {b}, z = {z:.2}");
            }
        }
    }
}
