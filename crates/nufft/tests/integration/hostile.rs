//! Random combinations of difficult points, numbers, frequencies and accuracies.

use num_complex::Complex;
use proptest::prelude::*;
use sphvar_nufft::{
    CircleTransform, ComplexTorusCoefficients, TorusCoefficients, TorusTransform, direct_adjoint,
    direct_adjoint_complex, direct_circle, direct_evaluate_complex, direct_gradient,
};

use crate::input::{EPSILONS, JUST_BELOW_1, Size, gradient_factors, real};

/// A coordinate: anywhere, at an edge, or on a regular grid.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..1.0,
        1 => Just(0.0),
        1 => Just(-0.0),
        1 => Just(5e-324),
        1 => Just(JUST_BELOW_1),
        2 => (1..70_u32).prop_flat_map(|n| (0..n).prop_map(move |j| f64::from(j) / f64::from(n))),
    ]
}

/// Points, each of them repeated.
fn points() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let point = ([coordinate(), coordinate()], prop_oneof![9 => 1..4_usize, 1 => 100..400_usize]);
    prop::collection::vec(point, 0..12)
        .prop_map(|points| points.iter().flat_map(|(p, n)| vec![*p; *n]).collect())
}

/// A number of any sign and scale, so that sums of thousands are finite.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1.0..1.0,
        1 => Just(0.0),
        2 => (-1.0..1.0, -300..300).prop_map(|(x, e)| x * 10f64.powi(e)),
        1 => Just(1e300),
        1 => Just(-1e-300),
    ]
}

fn numbers() -> impl Strategy<Value = Vec<Complex<f64>>> {
    let number = (number(), number()).prop_map(|(re, im)| Complex::new(re, im));
    prop::collection::vec(number, 1..20)
}

/// Repeats numbers to a length.
fn extended(numbers: &[Complex<f64>], len: usize) -> Vec<Complex<f64>> {
    numbers.iter().copied().cycle().take(len).collect()
}

fn epsilon() -> impl Strategy<Value = f64> {
    prop::sample::select(&EPSILONS)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn coefficients_are_accurate(
        kmax in 0..13_usize,
        epsilon in epsilon(),
        points in points(),
        numbers in numbers(),
    ) {
        let plan = TorusTransform::new(kmax, epsilon).unwrap();
        let weights = extended(&numbers, points.len());
        let size = Size::of(weights.iter().copied());
        let fast = plan.adjoint_complex(&points, &weights).unwrap();
        let exact = direct_adjoint_complex(kmax, &points, &weights).unwrap();
        let pairs = fast.values().iter().copied().zip(exact.values().iter().copied());
        size.assert_near("complex", epsilon, 1.0, pairs);

        let weights: Vec<f64> = weights.iter().map(|w| w.re).collect();
        let size = Size::of(weights.iter().copied().map(real));
        let fast = plan.adjoint(&points, Some(&weights)).unwrap();
        let exact = direct_adjoint(kmax, &points, Some(&weights)).unwrap();
        let pairs = fast.values().iter().copied().zip(exact.values().iter().copied());
        size.assert_near("real", epsilon, 1.0, pairs);

        let along: Vec<f64> = points.iter().map(|p| p[0]).collect();
        let plan = CircleTransform::new(50 * kmax, epsilon).unwrap();
        let fast = plan.adjoint(&along, Some(&weights)).unwrap();
        let exact = direct_circle(50 * kmax, &along, Some(&weights)).unwrap();
        size.assert_near("circle", epsilon, 1.0, fast.into_iter().zip(exact));
    }

    #[test]
    fn values_are_accurate(
        kmax in 0..13_usize,
        epsilon in epsilon(),
        points in points(),
        numbers in numbers(),
    ) {
        let plan = TorusTransform::new(kmax, epsilon).unwrap();
        let mut c = ComplexTorusCoefficients::zeros(kmax).unwrap();
        let values = extended(&numbers, c.values().len());
        c.values_mut().copy_from_slice(&values);
        let fast = plan.evaluate_complex(&c, &points).unwrap();
        let exact = direct_evaluate_complex(&c, &points).unwrap();
        Size::of(values).assert_near("complex", epsilon, 1.0, fast.into_iter().zip(exact));

        let mut c = TorusCoefficients::zeros(kmax).unwrap();
        let values = extended(&numbers, c.values().len());
        c.values_mut().copy_from_slice(&values);
        let size = Size::of_real(&c);
        let fast = plan.gradient(&c, &points).unwrap();
        let exact = direct_gradient(&c, &points).unwrap();
        for (i, factor) in gradient_factors(kmax, epsilon).into_iter().enumerate() {
            let pairs = fast.iter().zip(&exact).map(|(f, e)| (real(f[i]), real(e[i])));
            size.assert_near(&format!("part {i}"), epsilon, factor, pairs);
        }
    }
}
