//! Each pattern of the square against the property that defines it.

use std::f64::consts::{PI, TAU};

use rand::{Rng, RngExt};
use sphvar_samplers::checks::{is_latin_hypercube, is_stratified, lattice, net_parameter};
use sphvar_samplers::{
    FibonacciLattice, JitteredSquare, Lattice, Pmj02, Purpose, RegularSquare, SquareDistribution,
    SquarePattern, SquareSampler, Streams, toroidal_separation,
};

const REALIZATIONS: u64 = 4;

fn rng(index: u64) -> impl Rng {
    Streams::new(17, Purpose::Pattern, 3).realization(index)
}

fn sample(pattern: &SquarePattern, n: usize, index: u64) -> Vec<[f64; 2]> {
    pattern.build(n).unwrap().sample(&mut rng(index)).unwrap().points
}

#[test]
fn jittered_squares_have_one_point_in_every_cell() {
    for side in 1..40 {
        for index in 0..REALIZATIONS {
            let points = sample(&SquarePattern::JitteredSquare, side * side, index);
            assert!(is_stratified(&points, side, side), "{side}");
        }
    }
    for (rows, columns) in [(1, 1), (1, 50), (50, 1), (7, 12)] {
        let sampler = JitteredSquare::new(rows, columns).unwrap();
        assert!(is_stratified(&sampler.sample(&mut rng(0)).unwrap().points, rows, columns));
        assert!(matches!(
            sampler.distribution(),
            SquareDistribution::Jittered { rows: r, columns: c } if (r, c) == (rows, columns)
        ));
    }
}

#[test]
fn regular_squares_are_lattices_and_stratified() {
    for side in 1..40 {
        let points = sample(&SquarePattern::RegularSquare, side * side, 0);
        assert!(is_stratified(&points, side, side), "{side}");
        assert_eq!(lattice(&points), Lattice::grid(side, side).ok());
    }
    let points = RegularSquare::new(3, 20).unwrap().sample(&mut rng(0)).unwrap().points;
    assert_eq!(lattice(&points), Lattice::grid(3, 20).ok());
    assert_eq!((points[0], points[59]), ([0.5 / 3.0, 0.025], [2.5 / 3.0, 0.975]));
}

#[test]
fn latin_hypercubes_have_one_point_in_every_strip() {
    for n in (1..100).chain([1000, 4096]) {
        for index in 0..REALIZATIONS {
            assert!(is_latin_hypercube(&sample(&SquarePattern::LatinHypercube, n, index)), "{n}");
        }
    }
}

/// The order of the strips is uniform: each of the 24 of four points is as frequent.
#[test]
fn latin_hypercubes_have_uniform_orders() {
    const M: u64 = 6000;
    let mut counts = [0_u32; 64];
    for index in 0..M {
        let points = sample(&SquarePattern::LatinHypercube, 4, index);
        let quarter = |p: &[f64; 2]| (1..4).filter(|q| p[1] >= f64::from(*q) / 4.0).count();
        counts[points[..3].iter().fold(0, |code, p| 4 * code + quarter(p))] += 1;
    }
    let expected = M as f64 / 24.0;
    let seen: Vec<f64> = counts.iter().filter(|c| **c > 0).map(|c| f64::from(*c)).collect();
    let chi2: f64 = seen.iter().map(|c| (c - expected).powi(2) / expected).sum();
    // 23 degrees of freedom: beyond 65 in 7e-6 of seeds.
    assert!(seen.len() == 24 && chi2 < 65.0, "{} orders, {chi2}", seen.len());
}

/// The closed form of the power of Latin hypercubes, on the axes and off them.
#[test]
fn latin_hypercubes_have_the_stated_power() {
    const M: u64 = 4000;
    const N: usize = 5;
    const FREQUENCIES: [[i32; 2]; 8] =
        [[1, 0], [0, 1], [3, 0], [0, 4], [1, 1], [2, -1], [1, 4], [7, 3]];
    let sinc2 = |k: i32| {
        let x = PI * f64::from(k) / N as f64;
        if k == 0 { 1.0 } else { (x.sin() / x).powi(2) }
    };
    let mut sums = [[0.0; 2]; 8];
    for index in 0..M {
        let points = sample(&SquarePattern::LatinHypercube, N, index);
        for (sums, k) in sums.iter_mut().zip(FREQUENCIES) {
            let angle = |p: &[f64; 2]| TAU * (f64::from(k[0]) * p[0] + f64::from(k[1]) * p[1]);
            let parts = points.iter().map(|p| angle(p).sin_cos());
            let (sin, cos) = parts.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            let power = (sin * sin + cos * cos) / N as f64;
            *sums = [sums[0] + power, sums[1] + power * power];
        }
    }
    for ([sum, squares], k) in sums.into_iter().zip(FREQUENCIES) {
        let shared = sinc2(k[0]) * sinc2(k[1]);
        let is_on_axis = k.contains(&0);
        let expected = if is_on_axis { 1.0 - shared } else { 1.0 + shared / (N - 1) as f64 };
        let mean = sum / M as f64;
        let error = ((squares / M as f64 - mean * mean) / M as f64).sqrt();
        // 8 comparisons at 5 sigma: 5e-6 of seeds.
        assert!((mean - expected).abs() < 5.0 * error, "{k:?}: {mean} +- {error}, {expected}");
    }
}

#[test]
fn fibonacci_lattices_are_lattices_of_rank_1() {
    for n in (1..300).chain([987, 4181, 5000]) {
        let expected = FibonacciLattice::new(n).unwrap().lattice();
        let points = sample(&SquarePattern::FibonacciLattice, n, 0);
        assert_eq!((lattice(&points), points[0]), (Some(expected), [0.0; 2]), "{n}");
        // A generator coprime to N: the coordinates are distinct.
        assert!(is_latin_hypercube(&points), "{n}");
    }
    assert_eq!(Some(FibonacciLattice::new(55).unwrap().lattice()), Lattice::rank_1(55, 34).ok());
}

/// Roberts 2018 states that points are at least 0.549/sqrt(N) apart.
#[test]
fn points_of_r2_keep_apart() {
    for n in [2, 3, 5, 10, 33, 100, 317, 1000, 3162, 10_000] {
        let points = sample(&SquarePattern::R2, n, 0);
        let distance = toroidal_separation(&points, &()).unwrap().unwrap();
        assert!(distance * (n as f64).sqrt() > 0.3, "N = {n}: {distance}");
    }
}

/// Every prefix of 2^m points, and for Sobol's sequence every block, is a net with t = 0.
#[test]
fn prefixes_of_nets_are_nets() {
    for pattern in [SquarePattern::Pmj02, SquarePattern::SOBOL] {
        for index in 0..REALIZATIONS {
            let points = sample(&pattern, 1 << 11, index);
            for m in 0..=11 {
                let n = 1 << m;
                assert_eq!(net_parameter(&points[..n]), Some(0), "{pattern}, m = {m}");
                if m % 2 == 0 {
                    let side = 1 << (m / 2);
                    assert!(is_stratified(&points[..n], side, side), "{pattern}, m = {m}");
                }
                if pattern == SquarePattern::SOBOL {
                    assert!(points.chunks(n).all(|block| net_parameter(block) == Some(0)), "{m}");
                }
            }
        }
    }
}

#[test]
fn hammersley_and_halton_points_have_their_strata() {
    for m in 0..=11 {
        let points = sample(&SquarePattern::HAMMERSLEY, 1 << m, 0);
        assert_eq!(net_parameter(&points), Some(0), "m = {m}");
    }
    for n in 1..200 {
        assert!(is_stratified(&sample(&SquarePattern::HAMMERSLEY, n, 0), n, 1), "{n}");
    }
    let points = sample(&SquarePattern::HALTON, 1 << 12, 0);
    for (a, b) in (0..12).flat_map(|a| (0..7).map(move |b| (1 << a, 3_usize.pow(b)))) {
        // A block from a multiple of its length has one point in each elementary interval.
        for block in points.chunks_exact(a * b) {
            assert!(is_stratified(block, a, b), "{a} x {b}");
        }
    }
}

#[test]
fn first_points_of_sequences_do_not_depend_on_the_number_of_points() {
    let mut extensible = Vec::new();
    for pattern in crate::sequences::square_patterns() {
        let large = sample(&pattern, pattern.nearest_count(900), 5);
        let is_prefix = |requested: usize| {
            let n = pattern.nearest_count(requested);
            sample(&pattern, n, 5) == large[..n]
        };
        let begins = [1, 2, 3, 17, 64, 65, 100, 250, 700].into_iter().all(is_prefix);
        assert_eq!(pattern.facts().is_extensible, begins, "{pattern}");
        extensible.extend(begins.then(|| pattern.to_string()));
    }
    for name in ["white-square", "r2", "pmj02", "sobol", "halton"] {
        assert!(extensible.iter().any(|text| text == name), "{name}");
    }
}

/// The next 4^k points lie in the cells of the first, diagonally opposite.
#[test]
fn pmj02_is_progressive_multi_jittered() {
    for index in 0..REALIZATIONS {
        let points = sample(&SquarePattern::Pmj02, 1 << 12, index);
        for k in 0..6 {
            let (n, halves) = (1_usize << (2 * k), f64::from(2 << k));
            let half = |p: &[f64; 2]| p.map(|x| (x * halves).floor());
            for (p, q) in points[..n].iter().zip(&points[n..2 * n]) {
                let [p, q] = [half(p), half(q)];
                for d in 0..2 {
                    let same_cell = (p[d] / 2.0).floor() - (q[d] / 2.0).floor();
                    let distance = (p[d] - q[d]).abs() - 1.0;
                    assert!(same_cell.abs() + distance.abs() <= 0.0, "{k}: {p:?}, {q:?}");
                }
            }
        }
    }
}

/// The algorithm of the publication, by trial: a uniform point of the quarter until no elementary
/// interval holds two.
fn pmj02_by_trial(n: usize, rng: &mut dyn Rng) -> Vec<[f64; 2]> {
    let mut points = vec![rng.random::<[f64; 2]>()];
    while points.len() < n {
        let present = points.len();
        let m = present.trailing_zeros();
        let halves = f64::from(2_u32 << (m / 2));
        for index in present..2 * present {
            let (from, flips) = if m % 2 == 0 {
                (index - present, [true; 2])
            } else if index < present + present / 2 {
                (index - present, if rng.random() { [true, false] } else { [false, true] })
            } else {
                (index - present / 2, [true; 2])
            };
            let shares_an_interval = |p: &[f64; 2], q: &[f64; 2]| {
                (0..=m + 1).any(|a| {
                    let sides = [f64::from(1_u32 << a), f64::from(1_u32 << (m + 1 - a))];
                    (0..2).all(|d| {
                        let part = |x: f64| (x * sides[d]).floor();
                        part(p[d]).total_cmp(&part(q[d])).is_eq()
                    })
                })
            };
            loop {
                let unit: [f64; 2] = rng.random();
                let point = [0, 1].map(|d: usize| {
                    let half = (points[from][d] * halves).floor();
                    // The other half of the same cell.
                    let sibling = half + 1.0 - 2.0 * (half % 2.0);
                    ((if flips[d] { sibling } else { half }) + unit[d]) / halves
                });
                if points.iter().all(|q| !shares_an_interval(&point, q)) {
                    points.push(point);
                    break;
                }
            }
        }
    }
    points
}

/// The joint distributions of pairs of coordinates in eighths are those of the algorithm by trial.
#[test]
fn pmj02_has_the_distribution_of_its_publication() {
    const M: u64 = 4000;
    let sampler = Pmj02::new(16).unwrap();
    // Points of every doubling, and across doublings and coordinates.
    let pairs = [(0, 0, 0, 1), (1, 0, 3, 0), (2, 1, 3, 1), (5, 0, 9, 1), (12, 1, 15, 0)];
    let mut counts = [[[0.0_f64; 64]; 2]; 5];
    for index in 0..M {
        let sets = [
            sampler.sample(&mut rng(index)).unwrap().points,
            pmj02_by_trial(16, &mut rng(M + index)),
        ];
        for (which, points) in sets.iter().enumerate() {
            for (counts, (i, d, j, e)) in counts.iter_mut().zip(pairs) {
                let eighth = |x: f64| (1..8).filter(|k| x >= f64::from(*k) / 8.0).count();
                counts[which][8 * eighth(points[i][d]) + eighth(points[j][e])] += 1.0;
            }
        }
    }
    for ([fast, by_trial], pair) in counts.iter().zip(pairs) {
        let seen = fast.iter().zip(by_trial).filter(|(a, b)| **a + **b > 0.0);
        let (bins, chi2) = seen.fold((0.0, 0.0), |(bins, chi2), (a, b)| {
            (bins + 1.0, chi2 + (a - b).powi(2) / (a + b))
        });
        // Wilson and Hilferty 1931: normal beyond 5 in 3e-7 of seeds each, 1.5e-6 of all.
        let dof: f64 = bins - 1.0;
        let variance = 2.0 / (9.0 * dof);
        let z = ((chi2 / dof).cbrt() - (1.0 - variance)) / variance.sqrt();
        assert!(z < 5.0, "{pair:?}: chi2 {chi2} of {dof}");
    }
}
