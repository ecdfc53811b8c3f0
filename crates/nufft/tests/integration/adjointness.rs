//! `<A w, c> = <w, A* c>`: both types use the same window and corrections, so that the two sides agree
//! to rounding, whatever the accuracy of the transforms is.

use num_complex::Complex;
use sphvar_nufft::{ComplexTorusCoefficients, TorusCoefficients, TorusTransform};

use crate::input::{Size, uniform};

const KMAX: usize = 11;

/// Accuracies with grids in f32 and f64, and the rounding relative to the sums of weights and
/// coefficients: 100 units of the last digit.
const CASES: [(f64, f64); 4] = [(1e-1, 1.2e-5), (1e-4, 1.2e-5), (1e-7, 2.3e-14), (1e-12, 2.3e-14)];

fn points() -> Vec<[f64; 2]> {
    let mut next = uniform(51);
    (0..100).map(|_| [next(), next()]).collect()
}

fn numbers(n: usize) -> Vec<Complex<f64>> {
    let mut next = uniform(52);
    (0..n).map(|_| Complex::new(next() - 0.3, next() - 0.6)).collect()
}

#[test]
fn real_transforms_are_adjoint() {
    let points = points();
    let weights: Vec<f64> = numbers(100).iter().map(|c| c.re).collect();
    let mut c = TorusCoefficients::zeros(KMAX).unwrap();
    let random = numbers(c.values().len());
    c.values_mut().copy_from_slice(&random);
    for (epsilon, rounding) in CASES {
        let plan = TorusTransform::new(KMAX, epsilon).unwrap();
        let adjoint = plan.adjoint(&points, Some(&weights)).unwrap();
        let values = plan.evaluate(&c, &points).unwrap();
        let products = adjoint.values().iter().zip(c.values()).enumerate();
        let of_coefficients = products.map(|(i, (a, c))| {
            let multiplicity = if i % (KMAX + 1) == 0 { 1.0 } else { 2.0 };
            (a * c.conj()).re * multiplicity
        });
        let of_points = values.iter().zip(&weights).map(|(f, w)| f * w);
        let difference = of_coefficients.sum::<f64>() - of_points.sum::<f64>();
        let sums = Size::of(c.values().iter().copied()).sum * 2.0;
        let sums = sums * weights.iter().map(|w| w.abs()).sum::<f64>();
        assert!(difference.abs() <= rounding * sums, "{epsilon:e}: {:e}", difference / sums);
    }
}

#[test]
fn complex_transforms_are_adjoint() {
    let points = points();
    let weights = numbers(100);
    let mut c = ComplexTorusCoefficients::zeros(KMAX).unwrap();
    let random = numbers(c.values().len());
    c.values_mut().copy_from_slice(&random);
    for (epsilon, rounding) in CASES {
        let plan = TorusTransform::new(KMAX, epsilon).unwrap();
        let adjoint = plan.adjoint_complex(&points, &weights).unwrap();
        let values = plan.evaluate_complex(&c, &points).unwrap();
        let of_coefficients = adjoint.values().iter().zip(c.values()).map(|(a, c)| a * c.conj());
        let of_points = weights.iter().zip(&values).map(|(w, f)| w * f.conj());
        let difference = of_coefficients.sum::<Complex<f64>>() - of_points.sum::<Complex<f64>>();
        let [of_c, of_w] = [c.values(), &weights].map(|x| x.iter().map(|x| x.norm()).sum::<f64>());
        let error = difference.norm() / (of_c * of_w);
        assert!(error <= rounding, "{epsilon:e}: {error:e}");
    }
}
