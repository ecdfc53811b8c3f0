//! Values at points from coefficients.

use std::f64::consts::PI;

use sphvar_sh::{Alm, ylm_at};
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

use crate::coefficients::{norm, random, rounding, scaled};
use crate::definition::Definition;
use crate::points::{Lcg, Set, all, distinct};

const EPSILONS: [f64; 6] = [1e-3, 1e-5, 1e-6, 1e-8, 1e-10, 1e-13];

/// Returns the values by every method, with its stated accuracy.
fn by_all_methods(alm: &Alm, set: &Set) -> Vec<(f64, Vec<f64>)> {
    let lmax = alm.lmax();
    // A value that must be overwritten.
    let mut values = vec![f64::NAN; set.points.len()];
    let exact = ExactTransform::new(lmax).unwrap();
    exact.synthesis_into(alm, &set.points, &mut ExactWorkspace::default(), &mut values);
    let mut results = vec![(rounding(lmax), values.clone())];
    let mut workspace = FastWorkspace::default();
    for epsilon in EPSILONS {
        let plan = FastTransform::new(lmax, epsilon).unwrap();
        values.fill(f64::NAN);
        plan.synthesis_into(alm, &set.points, &mut workspace, &mut values);
        results.push((epsilon, values.clone()));
    }
    results
}

/// Returns the maximum and the root mean square difference.
fn differences(a: &[f64], b: &[f64]) -> (f64, f64) {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).collect();
    // `max` would ignore NaN.
    let largest = squares.iter().fold(0.0, |max: f64, s| if *s <= max { max } else { *s });
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (largest.sqrt(), mean.sqrt())
}

/// If the adjoint has accuracy `epsilon`, the transpose has, for random coefficients, an error of
/// `epsilon ||a|| / sqrt(4 pi)` on average, several times that at single points, and never more
/// than `epsilon ||a|| (lmax + 1) / sqrt(4 pi)`.
fn check_random(lmax: usize, n_points: usize) {
    let alm = random(lmax, &mut Lcg::new(21));
    let size = norm(&alm);
    for set in all(n_points) {
        let expected = Definition::new(&set.points).synthesis(&alm);
        for (epsilon, got) in by_all_methods(&alm, &set) {
            let (largest, mean) = differences(&got, &expected);
            let allowed = epsilon * size;
            assert!(
                mean <= allowed && largest <= allowed * (lmax as f64 + 1.0).sqrt(),
                "lmax {lmax}, {}, {epsilon:e}: {:.3} of ||a|| epsilon at most, {:.3} on average",
                set.name,
                largest / allowed,
                mean / allowed
            );
        }
    }
}

#[test]
fn random_coefficients_of_low_degree() {
    for lmax in [0, 1, 2, 17, 100] {
        check_random(lmax, 120);
    }
}

#[test]
fn random_coefficients_of_degree_513() {
    check_random(513, 40);
}

#[test]
fn a_function_that_is_large_at_one_point() {
    let lmax = 100;
    for set in all(30) {
        let Some(&peak) = set.points.first() else { continue };
        let alm = Definition::new(&[peak]).adjoint(None, lmax);
        let expected = Definition::new(&set.points).synthesis(&alm);
        let at_most = norm(&alm) * (lmax as f64 + 1.0) / (4.0 * PI).sqrt();
        for (epsilon, got) in by_all_methods(&alm, &set) {
            let (largest, _) = differences(&got, &expected);
            assert!(
                largest <= epsilon * at_most,
                "{}, {epsilon:e}: {:.3} of the tolerance",
                set.name,
                largest / (epsilon * at_most)
            );
        }
    }
}

#[test]
fn coefficients_of_any_size() {
    let lmax = 40;
    let alm = random(lmax, &mut Lcg::new(22));
    let mut failures = Vec::new();
    for set in distinct(60) {
        let expected = Definition::new(&set.points).synthesis(&alm);
        for size in [1e30, 1e-30, 1e150, 1e-150] {
            for (epsilon, got) in by_all_methods(&scaled(&alm, size), &set) {
                let got: Vec<f64> = got.iter().map(|f| f / size).collect();
                let (largest, _) = differences(&got, &expected);
                let allowed = epsilon * norm(&alm) * (lmax as f64 + 1.0).sqrt();
                if largest.is_nan() || largest > allowed {
                    failures.push(format!("{}, size {size:e}, {epsilon:e}: {largest:e}", set.name));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn exact_values_are_sums_of_harmonics() {
    for lmax in [0_u32, 1, 2, 9] {
        let alm = random(lmax as usize, &mut Lcg::new(23));
        for set in all(30) {
            let mut got = vec![f64::NAN; set.points.len()];
            let exact = ExactTransform::new(lmax as usize).unwrap();
            exact.synthesis_into(&alm, &set.points, &mut ExactWorkspace::default(), &mut got);
            for (p, got) in set.points.iter().zip(got) {
                let mut expected = 0.0;
                for l in 0..=lmax {
                    for m in -i64::from(l)..=i64::from(l) {
                        let y = ylm_at(l as usize, m, *p).unwrap();
                        expected += (alm.coefficient(l as usize, m) * y).re;
                    }
                }
                // 100 terms of size sqrt((2l + 1)/(4 pi)), each side with an error of a few (l + 1)
                // EPSILON.
                let tolerance = 8.0 * f64::EPSILON * f64::from(lmax + 1).powi(2);
                assert!(
                    (got - expected).abs() <= tolerance,
                    "lmax {lmax}, {}, {p:?}: {got} instead of {expected}",
                    set.name
                );
            }
        }
    }
}
