//! The transform from points to coefficients.

use std::f64::consts::TAU;

use num_complex::Complex;
use sphvar_nufft::{TorusCoefficients, TorusTransform, TorusWorkspace, direct_adjoint};

use crate::input::{EPSILONS, JUST_BELOW_1, uniform};

type Input = (&'static str, Vec<[f64; 2]>, Option<Vec<f64>>);

fn inputs() -> Vec<Input> {
    let mut next = uniform(3);
    let random: Vec<[f64; 2]> = (0..200).map(|_| [next(), next()]).collect();
    let signs: Vec<f64> = (0..200).map(|_| 2.0 * next() - 1.0).collect();
    let of_all_sizes = signs.iter().zip(0..).map(|(s, j)| s * 10f64.powi(3 * j - 300)).collect();
    let corners = [0.0, -0.0, 5e-324, 1e-17, 0.0625, 0.5, 1.0 - f64::EPSILON, JUST_BELOW_1];
    let corners: Vec<[f64; 2]> = corners.iter().flat_map(|&u| corners.map(|v| [u, v])).collect();
    let clustered = random.iter().map(|[u, v]| [1e-7 * u, JUST_BELOW_1 - 1e-7 * v]).collect();
    let lattice = (0..32 * 32).map(|j| [j % 32, j / 32].map(|i| f64::from(i) / 32.0)).collect();
    vec![
        ("none", vec![], None),
        ("none, weighted", vec![], Some(vec![])),
        ("one", vec![[0.3, 0.7]], None),
        ("one at the last place", vec![[JUST_BELOW_1; 2]], None),
        ("corners", corners, None),
        ("clustered", clustered, None),
        ("on the grid", lattice, None),
        ("signs", random.clone(), Some(signs)),
        ("huge weights", random.clone(), Some(vec![8e305; 200])),
        ("tiny weights", random.clone(), Some(vec![3e-310; 200])),
        ("zero weights", random.clone(), Some(vec![0.0; 200])),
        ("weights of all sizes", random.clone(), Some(of_all_sizes)),
        ("random", random, None),
    ]
}

/// Asserts the accuracy of every coefficient, and that of the norm for weights of one sign.
fn assert_near(
    name: &str,
    epsilon: f64,
    weights: &[f64],
    fast: &TorusCoefficients,
    exact: &TorusCoefficients,
) {
    // In units that keep squares in range.
    let unit = weights.iter().fold(f64::MIN_POSITIVE, |size, w| size.max(w.abs()));
    let sum: f64 = weights.iter().map(|w| w.abs() / unit).sum();
    let kmax = exact.kmax();
    let (mut squares, mut square_errors) = (0.0, 0.0);
    for (fast, exact) in fast.values().iter().zip(exact.values()) {
        let (fast, exact) = (fast / unit, exact / unit);
        let error = (fast - exact).norm();
        // Subnormal values are rounded to multiples of 5e-324.
        let rounding = 5e-324 / unit;
        assert!(
            error <= epsilon * sum + rounding,
            "{name}, kmax {kmax}, {epsilon:e}: {:e} of the weights",
            error / sum
        );
        squares += exact.norm_sqr();
        square_errors += error * error;
    }
    if sum > 0.0 && weights.iter().all(|&w| w >= f64::MIN_POSITIVE) {
        let off = (square_errors / squares).sqrt();
        assert!(off <= epsilon, "{name}, kmax {kmax}, {epsilon:e}: {off:e} of the norm");
    }
}

fn check(kmax: usize, epsilons: &[f64], (name, points, weights): &Input) {
    let weights = weights.as_deref();
    let exact = direct_adjoint(kmax, points, weights).unwrap();
    let ones = vec![1.0; points.len()];
    let mut workspace = TorusWorkspace::default();
    let mut fast = TorusCoefficients::zeros(kmax).unwrap();
    for &epsilon in epsilons {
        let plan = TorusTransform::new(kmax, epsilon).unwrap();
        plan.adjoint_into(points, weights, &mut workspace, &mut fast).unwrap();
        assert_near(name, epsilon, weights.unwrap_or(&ones), &fast, &exact);
    }
}

#[test]
fn the_requested_accuracy_is_met() {
    for input in inputs() {
        for kmax in [0, 1, 2, 7, 8, 31] {
            check(kmax, &EPSILONS, &input);
        }
    }
}

#[test]
fn the_requested_accuracy_is_met_for_many_frequencies() {
    let mut next = uniform(8);
    let points: Vec<[f64; 2]> = (0..12).map(|_| [next(), next()]).collect();
    for kmax in [100, 255, 256] {
        check(kmax, &EPSILONS, &("few", points.clone(), None));
    }
}

/// 20000 equal terms, whose rounding errors have the same sign in a plain sum.
#[test]
fn repeated_points_lose_no_accuracy() {
    for place in [[0.1, 0.2], [0.0, 0.0], [JUST_BELOW_1, 0.5]] {
        check(3, &EPSILONS, &("repeated", vec![place; 20_000], None));
    }
}

/// A single point has the coefficients exp(-2 pi i (k1 u + k2 v)). For dyadic coordinates they are
/// computed here from integers, so that the angle is rounded only in the last step.
#[test]
fn the_definition_matches_the_closed_form_of_a_point() {
    let (kmax, a, b, denominator) = (50, 12345_i32, 54321, 65536);
    let point = [f64::from(a) / f64::from(denominator), f64::from(b) / f64::from(denominator)];
    let c = direct_adjoint(50, &[point], Some(&[3.0])).unwrap();
    for k1 in -kmax..=kmax {
        for k2 in -kmax..=kmax {
            let angle =
                TAU * f64::from((k1 * a + k2 * b).rem_euclid(denominator)) / f64::from(denominator);
            let expected = Complex::from_polar(3.0, -angle);
            let got = c.get(k1, k2).unwrap();
            // Sine and cosine of an angle below 2 pi, rounded by 2^-52, and three products.
            assert!((got - expected).norm() < 3.0 * 12.0 * f64::EPSILON, "({k1}, {k2}): {got}");
        }
    }
}

/// A lattice of p x q points has the coefficient p q at multiples of (p, q), and zero elsewhere.
#[test]
fn a_lattice_has_the_coefficients_of_its_dual() {
    let (p, q) = (7, 12);
    let points: Vec<[f64; 2]> = (0..p * q)
        .map(|j| [f64::from(j % p) / f64::from(p), f64::from(j / p) / f64::from(q)])
        .collect();
    let fast = TorusTransform::new(40, 1e-12).unwrap().adjoint(&points, None).unwrap();
    let slow = direct_adjoint(40, &points, None).unwrap();
    for k1 in -40..=40 {
        for k2 in -40..=40 {
            let dual = k1 % 7 == 0 && k2 % 12 == 0;
            let expected = if dual { 84.0 } else { 0.0 };
            for (c, epsilon) in [(&fast, 1e-12), (&slow, 1e-14)] {
                let got = c.get(k1, k2).unwrap();
                assert!((got - expected).norm() <= 84.0 * epsilon, "({k1}, {k2}): {got}");
            }
        }
    }
}

#[test]
fn the_same_input_gives_bit_identical_results() {
    let (_, points, weights) = inputs().swap_remove(7);
    let mut workspace = TorusWorkspace::default();
    for epsilon in [1e-4, 1e-10] {
        let plan = TorusTransform::new(20, epsilon).unwrap();
        let alone = plan.adjoint(&points, weights.as_deref()).unwrap();
        // A larger transform of other points before.
        let larger = TorusTransform::new(60, epsilon).unwrap();
        let mut other = TorusCoefficients::zeros(60).unwrap();
        larger.adjoint_into(&[[0.5, 0.1]; 700], None, &mut workspace, &mut other).unwrap();
        let mut out = TorusCoefficients::zeros(20).unwrap();
        plan.adjoint_into(&points, weights.as_deref(), &mut workspace, &mut out).unwrap();
        assert_eq!(out, alone, "{epsilon:e}");
    }
}
