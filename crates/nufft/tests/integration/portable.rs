//! The code for processors without vector instructions, compared with the definitions.

use pulp::Arch;
use sphvar_nufft::{CircleTransform, TorusTransform, direct_adjoint, direct_circle};

#[test]
fn the_portable_torus_meets_the_requested_accuracy() {
    let points: Vec<[f64; 2]> = (0..200)
        .map(|j| [0.754877 * f64::from(j), 0.569840 * f64::from(j)].map(f64::fract))
        .collect();
    let exact = direct_adjoint(9, &points, None).unwrap();
    for epsilon in [1e-1, 1e-4, 1e-6, 1e-9, 1e-13] {
        let plan = TorusTransform::with_arch(9, epsilon, Arch::Scalar).unwrap();
        let fast = plan.adjoint(&points, None).unwrap();
        for (fast, exact) in fast.values().iter().zip(exact.values()) {
            assert!((fast - exact).norm() <= epsilon * 200.0, "{epsilon:e}: {fast}, {exact}");
        }
    }
}

#[test]
fn the_portable_circle_meets_the_requested_accuracy() {
    let points: Vec<f64> = (0..40).map(|j| (0.754877 * f64::from(j)).fract()).collect();
    for (kmax, epsilon) in [(9, 1e-1), (9, 1e-6), (4000, 1e-9), (4000, 1e-13)] {
        let exact = direct_circle(kmax, &points, None).unwrap();
        let plan = CircleTransform::with_arch(kmax, epsilon, Arch::Scalar).unwrap();
        for (fast, exact) in plan.adjoint(&points, None).unwrap().iter().zip(&exact) {
            assert!((fast - exact).norm() <= epsilon * 40.0, "{epsilon:e}: {fast}, {exact}");
        }
    }
}
