//! Batched and single transforms are bit-identical.

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

use crate::coefficients::random;
use crate::points::{Lcg, all};

const EPSILONS: [f64; 5] = [1e-3, 1e-5, 1e-6, 1e-9, 1e-13];

type Weighted = (Vec<DVec3>, Option<Vec<f64>>);

/// Returns nine sets of various sizes and positions, with and without weights, of different
/// magnitudes.
fn mixed() -> Vec<Weighted> {
    let mut rng = Lcg::new(51);
    let sets = all(130).into_iter().filter(|set| set.name != "clustered").enumerate();
    let sets = sets.map(|(i, set)| {
        let size = 10f64.powi(8 * (i32::try_from(i % 3).unwrap() - 1));
        let weights = rng.signed_numbers(set.points.len()).into_iter().map(|w| w * size);
        let weights = (i % 2 == 1).then(|| weights.collect());
        (set.points, weights)
    });
    sets.take(9).collect()
}

fn borrowed(sets: &[Weighted]) -> Vec<(&[DVec3], Option<&[f64]>)> {
    sets.iter().map(|(points, weights)| (points.as_slice(), weights.as_deref())).collect()
}

#[test]
fn adjoints() {
    let sets = mixed();
    assert_eq!(sets.len(), 9);
    for lmax in [0, 1, 2, 37] {
        for epsilon in EPSILONS {
            let plan = FastTransform::new(lmax, epsilon).unwrap();
            let mut workspace = FastWorkspace::default();
            let alone = borrowed(&sets).into_iter().map(|(points, weights)| {
                let mut alm = Alm::zeros(lmax).unwrap();
                plan.adjoint_into(points, weights, &mut workspace, &mut alm);
                alm
            });
            let alone: Vec<Alm> = alone.collect();
            for n in 1..=9 {
                // A workspace with another history, and outputs with old values.
                let mut together = vec![random(lmax, &mut Lcg::new(52)); n];
                plan.adjoint_batch_into(&borrowed(&sets[..n]), &mut workspace, &mut together);
                assert_eq!(together, alone[..n], "{n} sets, lmax {lmax}, epsilon {epsilon:e}");
                // The last set first.
                let mut rotated = sets[..n].to_vec();
                rotated.rotate_right(1);
                plan.adjoint_batch_into(&borrowed(&rotated), &mut workspace, &mut together);
                together.rotate_left(1);
                assert_eq!(
                    together,
                    alone[..n],
                    "{n} sets, lmax {lmax}, epsilon {epsilon:e}, rotated"
                );
            }
        }
    }
}

#[test]
fn syntheses() {
    let mut rng = Lcg::new(53);
    for (points, _) in mixed() {
        for lmax in [0, 1, 2, 37] {
            let alms: Vec<Alm> = (0..5).map(|_| random(lmax, &mut rng)).collect();
            for epsilon in EPSILONS {
                let plan = FastTransform::new(lmax, epsilon).unwrap();
                let mut workspace = FastWorkspace::default();
                let mut alone = vec![f64::NAN; alms.len() * points.len()];
                for (alm, out) in alms.iter().zip(alone.chunks_mut(points.len().max(1))) {
                    plan.synthesis_into(alm, &points, &mut workspace, out);
                }
                for n in 1..=5 {
                    let mut together = vec![f64::NAN; n * points.len()];
                    let functions: Vec<&Alm> = alms[..n].iter().collect();
                    plan.synthesis_batch_into(&functions, &points, &mut workspace, &mut together);
                    assert_eq!(
                        together,
                        alone[..together.len()],
                        "{n} functions, {} points, lmax {lmax}, epsilon {epsilon:e}",
                        points.len()
                    );
                }
            }
        }
    }
}

/// At high degrees and orders many lanes of the recurrence are negligible. Which ones are skipped
/// must not depend on the width of vectors, which depends on the other sets in the batch.
#[test]
#[ignore = "slow"]
fn high_degrees() {
    let mut rng = Lcg::new(54);
    for (lmax, epsilon) in [(333, 1e-5), (340, 2e-6), (512, 1e-12), (701, 1e-3)] {
        let plan = FastTransform::new(lmax, epsilon).unwrap();
        let mut workspace = FastWorkspace::default();
        for n_points in [1, 7, 600] {
            let sets: Vec<Weighted> = (0..5).map(|_| (rng.directions(n_points), None)).collect();
            let mut together = vec![Alm::zeros(lmax).unwrap(); 5];
            plan.adjoint_batch_into(&borrowed(&sets), &mut workspace, &mut together);
            for ((points, _), together) in sets.iter().zip(&together) {
                let mut alone = Alm::zeros(lmax).unwrap();
                plan.adjoint_into(points, None, &mut workspace, &mut alone);
                assert!(&alone == together, "adjoint, {n_points} points, lmax {lmax}");
            }
            let functions: Vec<&Alm> = together.iter().collect();
            let points = &sets[0].0;
            let mut values = vec![0.0; 5 * n_points];
            plan.synthesis_batch_into(&functions, points, &mut workspace, &mut values);
            for (alm, together) in functions.iter().zip(values.chunks(n_points)) {
                let mut alone = vec![0.0; n_points];
                plan.synthesis_into(alm, points, &mut workspace, &mut alone);
                assert_eq!(alone, together, "synthesis, {n_points} points, lmax {lmax}");
            }
        }
    }
}

#[test]
fn a_workspace_serves_transforms_of_any_degree_in_any_order() {
    let sets = mixed();
    let (mut used, mut used_exact) = (FastWorkspace::default(), ExactWorkspace::default());
    for (i, (points, weights)) in sets.iter().enumerate() {
        for lmax in [30, 3, 64, 0] {
            let epsilon = EPSILONS[(i + lmax) % EPSILONS.len()];
            let weights = weights.as_deref();
            let plan = FastTransform::new(lmax, epsilon).unwrap();
            let mut alm = Alm::zeros(lmax).unwrap();
            plan.adjoint_into(points, weights, &mut used, &mut alm);
            let mut fresh = Alm::zeros(lmax).unwrap();
            plan.adjoint_into(points, weights, &mut FastWorkspace::default(), &mut fresh);
            assert_eq!(alm, fresh, "adjoint, set {i}, lmax {lmax}, epsilon {epsilon:e}");

            let exact = ExactTransform::new(lmax).unwrap();
            exact.adjoint_into(points, weights, &mut used_exact, &mut alm);
            let fresh = exact.adjoint(points, weights).unwrap();
            assert_eq!(alm, fresh, "exact adjoint, set {i}, lmax {lmax}");

            let mut values = vec![f64::NAN; points.len()];
            let mut gradients = vec![DVec3::NAN; points.len()];
            let (mut values_again, mut gradients_again) = (values.clone(), gradients.clone());
            plan.gradient_into(&alm, points, &mut used, &mut values, &mut gradients);
            plan.gradient_into(
                &alm,
                points,
                &mut FastWorkspace::default(),
                &mut values_again,
                &mut gradients_again,
            );
            assert_eq!(values, values_again, "values, set {i}, lmax {lmax}, {epsilon:e}");
            assert_eq!(gradients, gradients_again, "set {i}, lmax {lmax}, epsilon {epsilon:e}");

            exact.gradient_into(&alm, points, &mut used_exact, &mut values, &mut gradients);
            exact.gradient_into(
                &alm,
                points,
                &mut ExactWorkspace::default(),
                &mut values_again,
                &mut gradients_again,
            );
            assert_eq!(values, values_again, "exact values, set {i}, lmax {lmax}");
            assert_eq!(gradients, gradients_again, "exact gradients, set {i}, lmax {lmax}");
        }
    }
}
