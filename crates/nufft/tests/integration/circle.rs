//! The transform of coordinates on the circle.

use num_complex::Complex;
use sphvar_nufft::{
    CircleTransform, CircleWorkspace, Error, MAX_CIRCLE_KMAX, direct_adjoint, direct_circle,
};

use crate::input::{EPSILONS, JUST_BELOW_1, uniform};

type Input = (&'static str, Vec<f64>, Option<Vec<f64>>);

fn inputs() -> Vec<Input> {
    let mut next = uniform(5);
    let random: Vec<f64> = (0..100).map(|_| next()).collect();
    let signs: Vec<f64> = (0..100).map(|_| 2.0 * next() - 1.0).collect();
    let of_all_sizes = signs.iter().zip(0..).map(|(s, j)| s * 10f64.powi(6 * j - 300)).collect();
    let edges =
        vec![0.0, -0.0, 5e-324, 1e-17, 0.0625, 0.5, 1.0 - f64::EPSILON, JUST_BELOW_1, JUST_BELOW_1];
    vec![
        ("none", vec![], None),
        ("none, weighted", vec![], Some(vec![])),
        ("one", vec![0.3], None),
        ("one, weighted", vec![JUST_BELOW_1], Some(vec![-3.0])),
        ("edges", edges, None),
        ("clustered", random.iter().map(|u| JUST_BELOW_1 - 1e-7 * u).collect(), None),
        ("on the grid", (0..64).map(|j| f64::from(j) / 64.0).collect(), None),
        ("signs", random.clone(), Some(signs)),
        ("huge weights", random.clone(), Some(vec![1e306; 100])),
        ("tiny weights", random.clone(), Some(vec![3e-310; 100])),
        ("zero weights", random.clone(), Some(vec![0.0; 100])),
        ("weights of all sizes", random, Some(of_all_sizes)),
    ]
}

/// Returns the largest error relative to the sum of the absolute weights.
fn largest_error(weights: &[f64], fast: &[Complex<f64>], exact: &[Complex<f64>]) -> f64 {
    // In units that keep sums in range; subnormal values are rounded to multiples of 5e-324.
    let unit = weights.iter().fold(f64::MIN_POSITIVE, |size, w| size.max(w.abs()));
    let sum: f64 = weights.iter().map(|w| w.abs() / unit).sum();
    let rounding = 5e-324 / unit;
    let errors = fast.iter().zip(exact).map(|(fast, exact)| (fast / unit - exact / unit).norm());
    let largest = errors.fold(0.0, |largest: f64, e| if e <= largest { largest } else { e });
    if largest <= rounding { 0.0 } else { (largest - rounding) / sum }
}

fn assert_accurate(kmax: usize, epsilons: &[f64], (name, points, weights): &Input) {
    let weights = weights.as_deref();
    let exact = direct_circle(kmax, points, weights).unwrap();
    let ones = vec![1.0; points.len()];
    let mut workspace = CircleWorkspace::default();
    let mut fast = vec![Complex::default(); kmax + 1];
    for &epsilon in epsilons {
        let plan = CircleTransform::new(kmax, epsilon).unwrap();
        plan.adjoint_into(points, weights, &mut workspace, &mut fast).unwrap();
        let error = largest_error(weights.unwrap_or(&ones), &fast, &exact);
        assert!(error <= epsilon, "{name}, kmax {kmax}, {epsilon:e}: {error:e} of the weights");
    }
}

#[test]
fn the_requested_accuracy_is_met() {
    for input in inputs() {
        for kmax in [0, 1, 2, 7, 16, 100, 1000] {
            assert_accurate(kmax, &EPSILONS, &input);
        }
    }
}

#[test]
fn the_requested_accuracy_is_met_to_frequency_2_to_the_17() {
    let mut next = uniform(8);
    let points = (0..3).map(|_| next()).chain([JUST_BELOW_1]).collect();
    assert_accurate(1 << 17, &[1e-1, 1e-9, 1e-13], &("few", points, None));
}

/// 100000 equal terms, whose rounding errors have the same sign in a plain sum.
#[test]
fn repeated_points_lose_no_accuracy() {
    for place in [0.1, 0.0, JUST_BELOW_1] {
        assert_accurate(3, &[1e-1, 1e-13], &("repeated", vec![place; 100_000], None));
    }
}

#[test]
fn points_on_an_axis_of_the_torus_have_the_same_coefficients() {
    let mut next = uniform(2);
    let points: Vec<f64> = (0..20).map(|_| next()).collect();
    let weights: Vec<f64> = (0..20).map(|_| next() - 0.4).collect();
    let circle = direct_circle(30, &points, Some(&weights)).unwrap();
    let on_axis: Vec<[f64; 2]> = points.iter().map(|&u| [u, 0.7]).collect();
    let torus = direct_adjoint(30, &on_axis, Some(&weights)).unwrap();
    for (k, c) in (0..).zip(&circle) {
        let difference = torus.get(k, 0).unwrap() - c;
        // A few roundings of 20 terms.
        assert!(difference.norm() < 20.0 * 4.0 * f64::EPSILON, "{k}: {difference}");
    }
}

#[test]
fn coordinates_in_f32_are_exact() {
    let points: Vec<f32> = vec![0.0, 0.1, 0.7, 1.0 - f32::EPSILON / 2.0];
    let weights = vec![1.0_f32, -3.0, 1e-30, 2.5];
    let wide = |x: &[f32]| -> Vec<f64> { x.iter().copied().map(f64::from).collect() };
    let exact = direct_circle(1000, &wide(&points), Some(&wide(&weights))).unwrap();
    let plan = CircleTransform::new(1000, 1e-9).unwrap();
    for (fast, exact) in plan.adjoint(&points, Some(&weights)).unwrap().iter().zip(exact) {
        // Results are rounded to f32.
        let error = (Complex::new(f64::from(fast.re), f64::from(fast.im)) - exact).norm();
        assert!(error <= 6.5 * (1e-9 + f64::from(f32::EPSILON)), "{fast}, {exact}");
    }
    assert_eq!(plan.adjoint(&[0.0; 2], Some(&[f32::MAX, f32::MAX])), Err(Error::Overflow));
}

#[test]
fn invalid_input_is_an_error() {
    let kmax = MAX_CIRCLE_KMAX + 1;
    let expected = Error::FrequencyTooLarge { kmax, max: MAX_CIRCLE_KMAX };
    assert_eq!(CircleTransform::new(kmax, 1e-3).unwrap_err(), expected);
    assert_eq!(direct_circle(kmax, &[], None).unwrap_err(), expected);
    for epsilon in [0.0, 0.99e-13, 0.1001, f64::NAN] {
        let error = CircleTransform::new(4, epsilon).unwrap_err();
        assert!(matches!(error, Error::Accuracy { .. }), "{epsilon}: {error}");
    }
    let plan = CircleTransform::new(4, 1e-3).unwrap();
    let both = |points: &[f64], weights: Option<&[f64]>| {
        let errors = [plan.adjoint(points, weights), direct_circle(4, points, weights)]
            .map(Result::unwrap_err);
        assert_eq!(errors[0].to_string(), errors[1].to_string());
        errors[0]
    };
    for bad in [1.0, -1e-300, f64::NAN, f64::INFINITY] {
        let error = both(&[0.0, bad], None);
        assert!(matches!(error, Error::Coordinate { index: 1, .. }), "{bad}: {error}");
    }
    let error = both(&[0.0; 3], Some(&[1.0, 2.0, f64::NAN]));
    assert!(matches!(error, Error::Weight { index: 2, .. }), "{error}");
    let expected = Error::WeightCount { weights: 1, points: 0 };
    assert_eq!(both(&[], Some(&[1.0])), expected);
    assert_eq!(both(&[0.0; 2], Some(&[f64::MAX, -1e300])), Error::Overflow);

    let mut out = vec![Complex::new(7.0, 0.0); 4];
    let error = plan.adjoint_into(&[0.5], None, &mut CircleWorkspace::default(), &mut out);
    assert_eq!(error, Err(Error::ValueCount { expected: 5, got: 4 }));
    assert_eq!(out, vec![Complex::new(7.0, 0.0); 4]);
}
