//! Extreme valid inputs give finite results; invalid inputs do not panic.

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace, Method, Transform};

use crate::coefficients::{distance, is_finite, norm, random, rounding};
use crate::definition::Definition;
use crate::points::{Lcg, Set, all};

const DEGREES: [usize; 4] = [0, 1, 2, 64];
const EPSILONS: [f64; 5] = [1e-3, 1e-6, 1e-7, 1e-10, 1e-13];

#[test]
fn every_set_gives_finite_and_accurate_results() {
    let mut sets = all(70);
    // The first point of each set alone.
    let single = sets.iter().filter(|set| !set.points.is_empty());
    let single: Vec<_> =
        single.map(|set| Set { name: set.name, points: vec![set.points[0]] }).collect();
    sets.extend(single);
    let (mut fast_workspace, mut exact_workspace) = Default::default();
    for lmax in DEGREES {
        let exact = ExactTransform::new(lmax).unwrap();
        let plans = EPSILONS.map(|epsilon| (epsilon, FastTransform::new(lmax, epsilon).unwrap()));
        let function = random(lmax, &mut Lcg::new(71));
        for set in &sets {
            let Set { name, points } = set;
            let n = points.len();
            let expected = Definition::new(points).adjoint(None, lmax);
            let size = norm(&expected);
            let (mut alm, mut values) = (Alm::zeros(lmax).unwrap(), vec![f64::NAN; n]);
            let mut gradients = vec![DVec3::NAN; n];
            let check =
                |method: String, alm: &Alm, values: &[f64], gradients: &[DVec3], epsilon| {
                    let error = distance(alm, &expected);
                    assert!(
                        error <= epsilon * size,
                        "{name}, {n} points, lmax {lmax}, {method}: {:e}",
                        error / size
                    );
                    assert!(
                        is_finite(alm)
                            && values.iter().all(|f| f.is_finite())
                            && gradients.iter().all(|g| g.is_finite()),
                        "{name}, {n} points, lmax {lmax}, {method}: {values:?} {gradients:?}"
                    );
                };
            exact.adjoint_into(points, None, &mut exact_workspace, &mut alm);
            exact.gradient_into(
                &function,
                points,
                &mut exact_workspace,
                &mut values,
                &mut gradients,
            );
            check("exact".into(), &alm, &values, &gradients, rounding(lmax));
            for (epsilon, plan) in &plans {
                values.fill(f64::NAN);
                gradients.fill(DVec3::NAN);
                plan.adjoint_into(points, None, &mut fast_workspace, &mut alm);
                plan.gradient_into(
                    &function,
                    points,
                    &mut fast_workspace,
                    &mut values,
                    &mut gradients,
                );
                check(format!("fast {epsilon:e}"), &alm, &values, &gradients, *epsilon);
            }
        }
    }
}

/// Returns vectors that are not directions.
fn invalid_directions() -> Vec<DVec3> {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, f64::MAX];
    let mut vectors = vec![DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::NEG_INFINITY];
    for x in bad {
        for p in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(-0.6, 0.0, 0.8)] {
            vectors.extend([p.with_x(x), p.with_y(x), p.with_z(x)]);
        }
    }
    vectors
}

#[test]
fn invalid_directions_do_not_affect_other_sets() {
    let good = Lcg::new(72).directions(30);
    let weights = Lcg::new(73).signed_numbers(30);
    let not_finite = [f64::NAN, f64::INFINITY, -f64::INFINITY].repeat(10);
    for lmax in DEGREES {
        for epsilon in EPSILONS {
            let plan = FastTransform::new(lmax, epsilon).unwrap();
            let mut workspace = FastWorkspace::default();
            let mut alone = Alm::zeros(lmax).unwrap();
            plan.adjoint_into(&good, Some(&weights), &mut workspace, &mut alone);
            for vector in invalid_directions() {
                let with_it = [good.as_slice(), &[vector]].concat();
                let mut outs = vec![Alm::zeros(lmax).unwrap(); 4];
                let sets = [
                    (with_it.as_slice(), None),
                    (good.as_slice(), Some(weights.as_slice())),
                    (&[vector], None),
                    (good.as_slice(), Some(not_finite.as_slice())),
                ];
                plan.adjoint_batch_into(&sets, &mut workspace, &mut outs);
                assert_eq!(outs[1], alone, "in a batch with {vector}, lmax {lmax}, {epsilon:e}");
                // Nor the results of later calls with the same workspace.
                plan.adjoint_into(&good, Some(&weights), &mut workspace, &mut outs[0]);
                assert_eq!(outs[0], alone, "after {vector}, lmax {lmax}, {epsilon:e}");
            }
        }
    }
}

#[test]
fn invalid_directions_do_not_affect_other_points() {
    let good = Lcg::new(74).directions(30);
    for lmax in DEGREES {
        let alm = random(lmax, &mut Lcg::new(75));
        let mut broken = alm.clone();
        broken.values_mut()[0].re = f64::NAN;
        let exact = ExactTransform::new(lmax).unwrap();
        let plans = EPSILONS.map(|epsilon| (epsilon, FastTransform::new(lmax, epsilon).unwrap()));
        let (mut exact_workspace, mut fast_workspace) =
            (ExactWorkspace::default(), FastWorkspace::default());
        let mut run = |alm: &Alm, points: &[DVec3]| {
            let mut values = vec![0.0; points.len()];
            let mut gradients = vec![DVec3::ZERO; points.len()];
            exact.gradient_into(alm, points, &mut exact_workspace, &mut values, &mut gradients);
            let mut results = vec![("exact".to_owned(), values.clone(), gradients.clone())];
            for (epsilon, plan) in &plans {
                plan.gradient_into(alm, points, &mut fast_workspace, &mut values, &mut gradients);
                results.push((format!("{epsilon:e}"), values.clone(), gradients.clone()));
            }
            results
        };
        let alone = run(&alm, &good);
        for vector in invalid_directions() {
            let with_it = [good.as_slice(), &[vector]].concat();
            let together = run(&alm, &with_it);
            // NaN coefficients, with the same workspace.
            run(&broken, &good);
            let later = run(&alm, &good);
            for ((alone, together), later) in alone.iter().zip(&together).zip(&later) {
                let (method, values, gradients) = alone;
                assert_eq!(values, &together.1[..30], "{vector}, lmax {lmax}, {method}");
                assert_eq!(gradients, &together.2[..30], "{vector}, lmax {lmax}, {method}");
                assert_eq!(alone, later, "after NaN, lmax {lmax}");
            }
        }
    }
}

/// Accuracies out of range are errors for every method; both ends of the range are supported.
#[test]
fn accuracies_outside_their_range_are_rejected() {
    let (min, max) = (FastTransform::MIN_EPSILON, FastTransform::MAX_EPSILON);
    let beyond = [min.next_down(), max.next_up(), 0.0, -0.0, -1e-3, 1e-300, 1.0, 7.0];
    for got in beyond.into_iter().chain([f64::INFINITY, f64::NEG_INFINITY, f64::NAN]) {
        let mut results = vec![FastTransform::new(20, got).map(drop)];
        for method in [Method::Auto, Method::Exact, Method::Fast] {
            results.push(Transform::new(method, 20, 9, got).map(drop));
        }
        for result in results {
            let message = result.unwrap_err().to_string();
            assert_eq!(message, format!("epsilon must be in [1e-13, 1e-1], got {got}"));
        }
    }
    let points = Lcg::new(76).directions(20);
    let expected = Definition::new(&points).adjoint(None, 20);
    for epsilon in [min, max] {
        let alm = FastTransform::new(20, epsilon).unwrap().adjoint(&points, None).unwrap();
        assert!(distance(&alm, &expected) <= epsilon * norm(&expected), "epsilon {epsilon:e}");
        for method in [Method::Auto, Method::Exact, Method::Fast] {
            assert!(Transform::new(method, 20, 9, epsilon).is_ok(), "{method:?} {epsilon:e}");
        }
    }
}
