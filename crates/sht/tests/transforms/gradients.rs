//! Values and gradients at points.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::{Alm, legendre_p_into};
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

use crate::coefficients::{norm, random, rounding};
use crate::definition::Definition;
use crate::points::{Lcg, all};

const EPSILONS: [f64; 5] = [1e-3, 1e-6, 1e-7, 1e-10, 1e-13];

/// Returns values and gradients by every method, with its stated accuracy.
fn by_all_methods(alm: &Alm, points: &[DVec3]) -> Vec<(f64, Vec<f64>, Vec<DVec3>)> {
    let lmax = alm.lmax();
    let mut values = vec![f64::NAN; points.len()];
    let mut gradients = vec![DVec3::NAN; points.len()];
    let exact = ExactTransform::new(lmax).unwrap();
    exact.gradient_into(alm, points, &mut ExactWorkspace::default(), &mut values, &mut gradients);
    let mut results = vec![(rounding(lmax), values.clone(), gradients.clone())];
    let mut workspace = FastWorkspace::default();
    for epsilon in EPSILONS {
        let plan = FastTransform::new(lmax, epsilon).unwrap();
        values.fill(f64::NAN);
        gradients.fill(DVec3::NAN);
        plan.gradient_into(alm, points, &mut workspace, &mut values, &mut gradients);
        results.push((epsilon, values.clone(), gradients.clone()));
    }
    results
}

/// Returns the maximum value of any function with this norm (Cauchy-Schwarz).
fn largest_value(alm: &Alm) -> f64 {
    norm(alm) * (alm.lmax() as f64 + 1.0) / (4.0 * PI).sqrt()
}

#[test]
fn gradients_are_tangent_and_values_match_synthesis() {
    for lmax in [0, 1, 2, 40] {
        let alm = random(lmax, &mut Lcg::new(61));
        let (value, slope) = (largest_value(&alm), lmax as f64 * largest_value(&alm));
        for set in all(80) {
            let expected = Definition::new(&set.points).synthesis(&alm);
            for (epsilon, values, gradients) in by_all_methods(&alm, &set.points) {
                for (i, p) in set.points.iter().enumerate() {
                    let error = (values[i] - expected[i]).abs();
                    assert!(
                        error <= epsilon * value,
                        "lmax {lmax}, {}, {p:?}, {epsilon:e}: value off by {error:e}",
                        set.name
                    );
                    // By construction, for any epsilon: the product of three rounding errors.
                    let normal = gradients[i].dot(*p).abs();
                    assert!(
                        normal <= 4.0 * f64::EPSILON * slope,
                        "lmax {lmax}, {}, {p:?}, {epsilon:e}: normal part {normal:e}",
                        set.name
                    );
                }
            }
        }
    }
}

#[test]
fn gradients_match_differences_of_values() {
    let lmax = 24;
    let alm = random(lmax, &mut Lcg::new(62));
    let exact = ExactTransform::new(lmax).unwrap();
    let mut workspace = ExactWorkspace::default();
    let value = largest_value(&alm);
    let degree = lmax as f64;
    let step = 4e-3 / degree;
    for set in all(60) {
        let methods = by_all_methods(&alm, &set.points);
        for (i, &p) in set.points.iter().enumerate() {
            let (east, north) = p.any_orthonormal_pair();
            for tangent in [east, north] {
                // The central difference of fourth order along a great circle.
                let places = [1.0, -1.0, 2.0, -2.0].map(|k: f64| {
                    let (sin, cos) = (k * step).sin_cos();
                    p * cos + tangent * sin
                });
                let mut f = [0.0; 4];
                exact.synthesis_into(&alm, &places, &mut workspace, &mut f);
                let difference = (8.0 * (f[0] - f[1]) - (f[2] - f[3])) / (12.0 * step);
                for (epsilon, _, gradients) in &methods {
                    // Along a great circle f is a trigonometric polynomial of degree L; each
                    // derivative adds a factor L (Bernstein): step^4 L^5 max|f|/30 for the
                    // difference, 3/2 of the error of f over the step for rounding, epsilon L
                    // max|f| for the gradient.
                    let truncated = (step * degree).powi(4) / 30.0;
                    let rounded = 1.5 * rounding(lmax) / (step * degree);
                    let tolerance = (truncated + rounded + epsilon) * degree * value;
                    let got = gradients[i].dot(tangent);
                    assert!(
                        (got - difference).abs() <= tolerance,
                        "{}, {p:?} along {tangent}, {epsilon:e}: {got} instead of {difference}",
                        set.name
                    );
                }
            }
        }
    }
}

#[test]
fn gradients_of_zonal_functions_match_closed_form() {
    let lmax = 30;
    // f(x) = sum_l c_l (2l + 1)/(4 pi) P_l(s . x)
    let factor = |l: usize| (1.3 * l as f64).cos() / (1.0 + 0.1 * l as f64);
    let centres =
        [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.48, -0.6, 0.64), Lcg::new(63).direction()];
    let mut legendre = vec![0.0; lmax + 1];
    for s in centres {
        let mut alm = Definition::new(&[s]).adjoint(None, lmax);
        for m in 0..=lmax {
            for (l, a) in (m..).zip(alm.column_mut(m)) {
                *a *= factor(l);
            }
        }
        let slope = lmax as f64 * largest_value(&alm);
        let mut sets = all(60);
        for set in &mut sets {
            set.points.extend([s, -s, DVec3::Z, -DVec3::Z, DVec3::new(1e-160, -1e-160, -1.0)]);
        }
        for set in sets {
            let methods = by_all_methods(&alm, &set.points);
            for (i, &x) in set.points.iter().enumerate() {
                let t = s.dot(x).clamp(-1.0, 1.0);
                legendre_p_into(t, &mut legendre).unwrap();
                // P'_l = P'_{l-2} + (2l - 1) P_{l-1}
                let (mut before, mut own, mut sum) = (0.0, 0.0, 0.0);
                for l in 0..=lmax {
                    let next =
                        if l > 0 { before + (2 * l - 1) as f64 * legendre[l - 1] } else { 0.0 };
                    (before, own) = (own, next);
                    sum += factor(l) * (2 * l + 1) as f64 / (4.0 * PI) * own;
                }
                // (x cross s) cross x = s - (s . x) x, without cancellation.
                let expected = x.cross(s).cross(x) * sum;
                for (epsilon, _, gradients) in &methods {
                    let error = (gradients[i] - expected).length();
                    assert!(
                        error <= (epsilon + rounding(lmax)) * slope,
                        "s = {s}, x = {x:?}, {}, {epsilon:e}: {} instead of {expected}",
                        set.name,
                        gradients[i]
                    );
                }
            }
        }
    }
}
