//! Input and output in f32: coordinates and weights are exact, and results are rounded to f32.

use num_complex::Complex;
use sphvar_nufft::{
    ComplexTorusCoefficients, Error, TorusCoefficients, TorusTransform, direct_adjoint,
    direct_adjoint_complex, direct_evaluate_complex, direct_gradient,
};

use crate::input::{Size, gradient_factors, real, uniform};

const KMAX: usize = 9;

fn points() -> (Vec<[f32; 2]>, Vec<[f64; 2]>) {
    let mut next = uniform(71);
    let edges = [[0.0, 1.0 - f32::EPSILON / 2.0], [1e-45, 0.1]];
    #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
    let random = (0..50).map(|_| [next() as f32 * 0.99, next() as f32 * 0.99]);
    let points: Vec<[f32; 2]> = random.chain(edges).collect();
    let exact = points.iter().map(|p| p.map(f64::from)).collect();
    (points, exact)
}

fn numbers(n: usize) -> Vec<Complex<f32>> {
    let mut next = uniform(72);
    #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
    let mut number = || (next() - 0.4) as f32;
    (0..n).map(|_| Complex::new(number(), number())).collect()
}

fn wide(c: &Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(c.re), f64::from(c.im))
}

fn pairs<'a>(
    fast: &'a [Complex<f32>],
    exact: &'a [Complex<f64>],
) -> impl Iterator<Item = (Complex<f64>, Complex<f64>)> {
    fast.iter().map(wide).zip(exact.iter().copied())
}

/// The accuracy of the transforms and that of results, which are rounded by 2^-24.
const CASES: [(f64, f64); 2] = [(1e-3, 1e-3 + 6e-8), (1e-9, 6.1e-8)];

#[test]
fn coefficients_have_the_accuracy_of_f32() {
    let (points, exact_points) = points();
    let weights = numbers(points.len());
    let (re, exact_re): (Vec<f32>, Vec<f64>) =
        weights.iter().map(|w| (w.re, f64::from(w.re))).unzip();
    let exact_weights: Vec<_> = weights.iter().map(wide).collect();
    let exact = direct_adjoint(KMAX, &exact_points, Some(&exact_re)).unwrap();
    let exact_complex = direct_adjoint_complex(KMAX, &exact_points, &exact_weights).unwrap();
    for (epsilon, accuracy) in CASES {
        let plan = TorusTransform::new(KMAX, epsilon).unwrap();
        let fast = plan.adjoint(&points, Some(&re)).unwrap();
        let size = Size::of(exact_re.iter().copied().map(real));
        size.assert_near("real", accuracy, 1.0, pairs(fast.values(), exact.values()));
        let fast = plan.adjoint_complex(&points, &weights).unwrap();
        let size = Size::of(exact_weights.iter().copied());
        size.assert_near("complex", accuracy, 1.0, pairs(fast.values(), exact_complex.values()));
    }
    let two = [[0.0_f32; 2]; 2];
    let plan = TorusTransform::new(KMAX, 1e-3).unwrap();
    assert_eq!(plan.adjoint(&two, Some(&[f32::MAX; 2])), Err(Error::Overflow));
}

#[test]
fn values_have_the_accuracy_of_f32() {
    let (points, exact_points) = points();
    let mut c = ComplexTorusCoefficients::zeros(KMAX).unwrap();
    let mut exact_c = ComplexTorusCoefficients::zeros(KMAX).unwrap();
    let random = numbers(c.values().len());
    c.values_mut().copy_from_slice(&random);
    exact_c.values_mut().iter_mut().zip(&random).for_each(|(to, from)| *to = wide(from));
    let mut half = TorusCoefficients::zeros(KMAX).unwrap();
    let mut exact_half = TorusCoefficients::zeros(KMAX).unwrap();
    half.values_mut().iter_mut().zip(&random).for_each(|(to, from)| *to = *from);
    exact_half.values_mut().iter_mut().zip(&random).for_each(|(to, from)| *to = wide(from));
    let exact = direct_evaluate_complex(&exact_c, &exact_points).unwrap();
    let exact_gradient = direct_gradient(&exact_half, &exact_points).unwrap();
    for (epsilon, accuracy) in CASES {
        let plan = TorusTransform::new(KMAX, epsilon).unwrap();
        let size = Size::of(exact_c.values().iter().copied());
        let fast = plan.evaluate_complex(&c, &points).unwrap();
        size.assert_near("complex", accuracy, 1.0, pairs(&fast, &exact));
        // Sums over half of the coefficients are smaller.
        let fast = plan.gradient(&half, &points).unwrap();
        let values = plan.evaluate(&half, &points).unwrap();
        let size = Size::of_real(&exact_half);
        let both = fast.iter().zip(&exact_gradient);
        size.assert_near(
            "values",
            accuracy,
            1.0,
            both.clone().map(|(f, e)| (real(f64::from(f[0])), real(e[0]))),
        );
        for i in [1, 2] {
            let factor = gradient_factors(KMAX, epsilon)[i];
            let pairs = both.clone().map(|(f, e)| (real(f64::from(f[i])), real(e[i])));
            size.assert_near("derivatives", accuracy, factor, pairs);
        }
        let pairs = values.iter().zip(&exact_gradient);
        size.assert_near(
            "values",
            accuracy,
            1.0,
            pairs.map(|(f, e)| (real(f64::from(*f)), real(e[0]))),
        );
    }
}
