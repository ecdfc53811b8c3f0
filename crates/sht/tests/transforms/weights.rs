//! Weights of either sign and of any size.

use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, FastTransform, FastWorkspace};

use crate::coefficients::{distance, norm, rounding, scaled};
use crate::definition::Definition;
use crate::points::{Lcg, Set, all};

const LMAX: usize = 60;
const EPSILONS: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-13];

/// Returns the coefficients by every method, with its stated accuracy.
fn by_all_methods(set: &Set, weights: Option<&[f64]>) -> Vec<(f64, Alm)> {
    let exact = ExactTransform::new(LMAX).unwrap().adjoint(&set.points, weights).unwrap();
    let mut results = vec![(rounding(LMAX), exact)];
    for epsilon in EPSILONS {
        let mut alm = Alm::zeros(LMAX).unwrap();
        let plan = FastTransform::new(LMAX, epsilon).unwrap();
        plan.adjoint_into(&set.points, weights, &mut FastWorkspace::default(), &mut alm);
        results.push((epsilon, alm));
    }
    results
}

#[test]
fn errors_are_relative_to_the_absolute_weights() {
    let mut rng = Lcg::new(11);
    for set in all(120) {
        let definition = Definition::new(&set.points);
        for size in [1.0, 1e30, 1e-30] {
            let weights = rng.signed_numbers(set.points.len()).into_iter().map(|w| w * size);
            let weights: Vec<f64> = weights.collect();
            let positive: Vec<f64> = weights.iter().map(|w| w.abs()).collect();
            let expected = definition.adjoint(Some(&weights), LMAX);
            let scale = norm(&definition.adjoint(Some(&positive), LMAX));
            for (epsilon, got) in by_all_methods(&set, Some(&weights)) {
                let error = distance(&got, &expected);
                assert!(
                    error <= epsilon * scale,
                    "{}, weights of size {size:e}, {epsilon:e}: {:e}",
                    set.name,
                    error / scale
                );
            }
        }
    }
}

#[test]
fn a_single_large_weight_keeps_results_accurate() {
    for set in all(120) {
        let mut weights = vec![1.0; set.points.len()];
        if let Some(first) = weights.first_mut() {
            *first = 1e200;
        }
        let expected = Definition::new(&set.points).adjoint(Some(&weights), LMAX);
        // The squares of the norm overflow.
        let lowered = scaled(&expected, 1e-200);
        for (epsilon, got) in by_all_methods(&set, Some(&weights)) {
            let error = distance(&scaled(&got, 1e-200), &lowered);
            assert!(error <= epsilon * norm(&lowered), "{}, {epsilon:e}: {error:e}", set.name);
        }
    }
}

#[test]
fn weights_below_the_normal_numbers() {
    // Numbers below 2^-1022 are multiples of 2^-1074.
    let (lift, unit) = (2f64.powi(1000), 2f64.powi(-74));
    let mut rng = Lcg::new(12);
    for set in all(120) {
        let weights = rng.signed_numbers(set.points.len()).into_iter().map(|w| w * 1e-310);
        let weights: Vec<f64> = weights.collect();
        let lifted: Vec<f64> = weights.iter().map(|w| w * lift).collect();
        let positive: Vec<f64> = lifted.iter().map(|w| w.abs()).collect();
        let definition = Definition::new(&set.points);
        let expected = definition.adjoint(Some(&lifted), LMAX);
        let scale = norm(&definition.adjoint(Some(&positive), LMAX));
        for (epsilon, got) in by_all_methods(&set, Some(&weights)) {
            // A power of two above the range of f64, in two steps.
            let got = scaled(&got, lift);
            let error = distance(&got, &expected);
            // The term of every point is rounded to a multiple of the unit at each order, and the
            // result once more.
            let degrees = (LMAX + 1) as f64;
            let rounded = unit * degrees * (1.0 + set.points.len() as f64 * degrees.sqrt());
            assert!(
                error <= epsilon * scale + rounded,
                "{}, {epsilon:e}: {:e}, rounding {:e}",
                set.name,
                error / scale,
                rounded / scale
            );
        }
    }
}

#[test]
fn zero_weights_give_zero() {
    for set in all(120) {
        for zero in [0.0, -0.0] {
            let weights = vec![zero; set.points.len()];
            for (epsilon, got) in by_all_methods(&set, Some(&weights)) {
                let size = norm(&got);
                assert!(size == 0.0, "{}, {epsilon:e}: {size:e}", set.name);
            }
        }
    }
}

#[test]
fn unit_weights_equal_no_weights() {
    for set in all(120) {
        let ones = vec![1.0; set.points.len()];
        assert_eq!(by_all_methods(&set, Some(&ones)), by_all_methods(&set, None), "{}", set.name);
    }
}
