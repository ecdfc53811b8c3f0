//! The adjoint transforms meet their stated accuracy.

use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, FastTransform, FastWorkspace};

use crate::coefficients::{distance, norm, rounding};
use crate::definition::Definition;
use crate::points::{Set, distinct};

/// Every power of ten, and the minimum accuracies of f32 grids and sums.
const ALL: [f64; 15] =
    [1e-3, 1e-4, 1e-5, 4e-6, 2e-6, 1e-6, 5e-7, 2e-7, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];
/// The ends of the accuracy ranges of each kind of grid, and those with the narrowest windows.
const SOME: [f64; 8] = [1e-3, 1e-5, 5e-7, 2e-7, 1e-8, 1e-9, 1e-12, 1e-13];

/// Compares with the definition and reports all failures.
fn check(lmax: usize, sets: &[Set], epsilons: &[f64]) {
    let expected: Vec<Alm> =
        sets.iter().map(|set| Definition::new(&set.points).adjoint(None, lmax)).collect();
    let mut failures = Vec::new();
    let mut compare = |method: String, got: &[Alm], epsilon: f64| {
        // What rounding in the recurrence over the degree permits.
        let epsilon = epsilon.max(0.5 * f64::EPSILON * lmax as f64);
        for ((set, expected), got) in sets.iter().zip(&expected).zip(got) {
            let error = distance(got, expected) / norm(expected);
            if error.is_nan() || error > epsilon {
                failures.push(format!(
                    "{method}, lmax {lmax}, {}: error {error:.2e}, {:.3} of the tolerance",
                    set.name,
                    error / epsilon,
                ));
            }
        }
    };
    let exact = ExactTransform::new(lmax).unwrap();
    let got: Vec<Alm> = sets.iter().map(|set| exact.adjoint(&set.points, None).unwrap()).collect();
    compare("exact".into(), &got, rounding(lmax));

    let batch: Vec<_> = sets.iter().map(|set| (set.points.as_slice(), None)).collect();
    let mut got = vec![Alm::zeros(lmax).unwrap(); sets.len()];
    let mut workspace = FastWorkspace::default();
    for &epsilon in epsilons {
        let plan = FastTransform::new(lmax, epsilon).unwrap();
        plan.adjoint_batch_into(&batch, &mut workspace, &mut got);
        compare(format!("fast {epsilon:e}"), &got, epsilon);
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn lowest_degrees() {
    for lmax in [0, 1, 2] {
        check(lmax, &distinct(200), &ALL);
    }
}

#[test]
fn degree_17() {
    check(17, &distinct(200), &ALL);
}

#[test]
fn degree_100() {
    check(100, &distinct(200), &ALL);
}

#[test]
fn degree_513() {
    check(513, &distinct(40), &ALL);
}

#[test]
#[ignore = "slow"]
fn degree_2048() {
    let mut sets = distinct(40);
    // One lattice is enough at this cost.
    sets.retain(|set| set.name != "Fibonacci lattice");
    check(2048, &sets, &SOME);
}
