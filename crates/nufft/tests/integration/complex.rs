//! Complex weights and functions, and batches of weights.

use num_complex::Complex;
use sphvar_nufft::{
    ComplexTorusCoefficients, TorusCoefficients, TorusTransform, TorusWorkspace,
    direct_adjoint_complex, direct_evaluate_complex,
};

use crate::input::{EPSILONS, JUST_BELOW_1, Size, uniform};

fn points(n: usize) -> Vec<[f64; 2]> {
    let mut next = uniform(31);
    let random = (0..n).map(|_| [next(), next()]);
    random.chain([[0.0; 2], [JUST_BELOW_1; 2], [0.0, JUST_BELOW_1]]).collect()
}

fn numbers(n: usize, size: impl Fn(usize) -> f64) -> Vec<Complex<f64>> {
    let mut next = uniform(32);
    (0..n).map(|i| Complex::new(2.0 * next() - 1.0, 2.0 * next() - 1.0) * size(i)).collect()
}

type SizeOf = fn(usize) -> f64;

/// Sizes of weights or coefficients by name.
fn sizes() -> [(&'static str, SizeOf); 4] {
    [
        ("of one size", |_| 1.0),
        ("huge", |_| 1e304),
        ("tiny", |_| 1e-309),
        ("of all sizes", |i| 10f64.powi(i32::try_from(37 * i % 600).unwrap() - 300)),
    ]
}

#[test]
fn coefficients_meet_the_requested_accuracy() {
    let points = points(40);
    for (name, size) in sizes() {
        let weights = numbers(points.len(), size);
        for kmax in [0, 1, 9] {
            let exact = direct_adjoint_complex(kmax, &points, &weights).unwrap();
            let mut workspace = TorusWorkspace::default();
            let mut fast = ComplexTorusCoefficients::zeros(kmax).unwrap();
            for epsilon in EPSILONS {
                let plan = TorusTransform::new(kmax, epsilon).unwrap();
                plan.adjoint_complex_into(&points, &weights, &mut workspace, &mut fast).unwrap();
                let pairs = fast.values().iter().copied().zip(exact.values().iter().copied());
                Size::of(weights.iter().copied()).assert_near(name, epsilon, 1.0, pairs);
            }
        }
    }
}

#[test]
fn values_meet_the_requested_accuracy() {
    let points = points(40);
    for (name, size) in sizes() {
        for kmax in [0, 1, 9] {
            let mut c = ComplexTorusCoefficients::zeros(kmax).unwrap();
            let len = c.values().len();
            // A sum of 361 numbers of 1e304 is finite.
            c.values_mut().copy_from_slice(&numbers(len, size));
            let exact = direct_evaluate_complex(&c, &points).unwrap();
            let mut workspace = TorusWorkspace::default();
            let mut fast = vec![Complex::default(); points.len()];
            for epsilon in EPSILONS {
                let plan = TorusTransform::new(kmax, epsilon).unwrap();
                plan.evaluate_complex_into(&c, &points, &mut workspace, &mut fast).unwrap();
                let pairs = fast.iter().copied().zip(exact.iter().copied());
                Size::of(c.values().iter().copied()).assert_near(name, epsilon, 1.0, pairs);
            }
        }
    }
}

#[test]
fn weights_of_a_batch_have_the_coefficients_of_single_calls() {
    // Tiles with few points, and one with enough for compensated sums.
    for points in [points(300), vec![[0.3, 0.7]; 9000]] {
        let weights: Vec<Vec<f64>> = (0..5)
            .map(|b| numbers(points.len(), |i| (i + b) as f64).iter().map(|c| c.re).collect())
            .collect();
        let mut workspace = TorusWorkspace::default();
        for epsilon in [1e-4, 1e-10] {
            let plan = TorusTransform::new(12, epsilon).unwrap();
            for n in 0..=5 {
                let batch: Vec<&[f64]> = weights[..n].iter().map(Vec::as_slice).collect();
                let mut outs = vec![TorusCoefficients::zeros(12).unwrap(); n];
                plan.adjoint_batch_into(&points, &batch, &mut workspace, &mut outs).unwrap();
                for (b, (weights, out)) in batch.iter().zip(&outs).enumerate() {
                    let alone = plan.adjoint(&points, Some(weights)).unwrap();
                    assert_eq!(*out, alone, "weights {b} of {n}, {epsilon:e}");
                }
            }
        }
    }
}
