//! Many points per grid cell: long sums are as accurate as short ones.

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, FastTransform, FastWorkspace};

use crate::coefficients::{distance, norm, rounding, scaled};
use crate::definition::Definition;
use crate::points::{Lcg, distinct};

const LMAX: usize = 60;
const POINTS: usize = 20000;
const EPSILONS: [f64; 9] = [1e-3, 1e-4, 1e-5, 1e-6, 5e-7, 2e-7, 1e-9, 1e-12, 1e-13];

/// Returns all failures.
fn failures(name: &str, points: &[DVec3], expected: &Alm) -> Vec<String> {
    let exact = ExactTransform::new(LMAX).unwrap().adjoint(points, None).unwrap();
    // Rounding errors of a long sum with random signs, two per term.
    let mut results =
        vec![("exact", rounding(LMAX) + 2.0 * (POINTS as f64).sqrt() * f64::EPSILON, exact)];
    let mut workspace = FastWorkspace::default();
    for epsilon in EPSILONS {
        let mut alm = Alm::zeros(LMAX).unwrap();
        let plan = FastTransform::new(LMAX, epsilon).unwrap();
        plan.adjoint_into(points, None, &mut workspace, &mut alm);
        results.push(("fast", epsilon, alm));
    }
    let errors = results
        .into_iter()
        .map(|(method, epsilon, alm)| (method, epsilon, distance(&alm, expected) / norm(expected)));
    let errors = errors.filter(|(_, epsilon, error)| error.is_nan() || error > epsilon);
    let message = |(method, epsilon, error): (&str, f64, f64)| {
        format!("{name}, {method} {epsilon:.1e}: {:.3} of the tolerance", error / epsilon)
    };
    errors.map(message).collect()
}

#[test]
fn many_points_at_one_place() {
    let directions = Lcg::new(81).directions(2).into_iter();
    let places = directions.chain([DVec3::new(-0.6, 0.0, 0.8), DVec3::Z, DVec3::Y]);
    let failures: Vec<String> = places
        .flat_map(|place| {
            let expected = scaled(&Definition::new(&[place]).adjoint(None, LMAX), POINTS as f64);
            failures(&place.to_string(), &[place; POINTS], &expected)
        })
        .collect();
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn many_distinct_points() {
    let mut sets = distinct(POINTS);
    sets.retain(|set| ["random", "clustered", "equatorial"].contains(&set.name));
    let failures: Vec<String> = sets
        .iter()
        .flat_map(|set| {
            let expected = Definition::new(&set.points).adjoint(None, LMAX);
            failures(set.name, &set.points, &expected)
        })
        .collect();
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
#[ignore = "slow"]
fn a_million_points_at_one_place() {
    // All rounding errors of a plain sum have the same sign here, 1e-19 of the sum per point.
    const MILLION: usize = 1_000_000;
    const DEGREE: usize = 16;
    for place in [DVec3::new(-0.6, 0.0, 0.8), DVec3::new(0.36, -0.48, 0.8)] {
        let expected = scaled(&Definition::new(&[place]).adjoint(None, DEGREE), MILLION as f64);
        let points = vec![place; MILLION];
        let exact = ExactTransform::new(DEGREE).unwrap().adjoint(&points, None).unwrap();
        let mut results = vec![("exact", rounding(DEGREE), exact)];
        let mut workspace = FastWorkspace::default();
        for epsilon in [1e-5, 5e-7, 1e-9, 1e-13] {
            let mut alm = Alm::zeros(DEGREE).unwrap();
            let plan = FastTransform::new(DEGREE, epsilon).unwrap();
            plan.adjoint_into(&points, None, &mut workspace, &mut alm);
            results.push(("fast", epsilon, alm));
        }
        for (method, epsilon, alm) in results {
            let error = distance(&alm, &expected) / norm(&expected);
            assert!(error <= epsilon, "{place}, {method} {epsilon:e}: {error:e}");
        }
    }
}
