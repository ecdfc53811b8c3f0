//! The power per degree of a set of points is invariant under rotations.

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, FastTransform, FastWorkspace};

use crate::coefficients::{norm, rounding};
use crate::points::{Lcg, distinct};

const LMAX: usize = 90;

fn by_all_methods(points: &[DVec3], workspace: &mut FastWorkspace) -> Vec<(f64, Alm)> {
    let exact = ExactTransform::new(LMAX).unwrap().adjoint(points, None).unwrap();
    let mut results = vec![(rounding(LMAX), exact)];
    for epsilon in [1e-3, 1e-6, 1e-7, 1e-10, 1e-13] {
        let mut alm = Alm::zeros(LMAX).unwrap();
        let plan = FastTransform::new(LMAX, epsilon).unwrap();
        plan.adjoint_into(points, None, workspace, &mut alm);
        results.push((epsilon, alm));
    }
    results
}

#[test]
fn power_is_invariant_under_rotations() {
    let mut rng = Lcg::new(41);
    let mut workspace = FastWorkspace::default();
    for set in distinct(100) {
        let before = by_all_methods(&set.points, &mut workspace);
        for _ in 0..4 {
            let rotation = rng.rotation();
            let rotated: Vec<DVec3> = set.points.iter().map(|&p| rotation * p).collect();
            let after = by_all_methods(&rotated, &mut workspace);
            for ((epsilon, before), (_, after)) in before.iter().zip(&after) {
                // The error of ||a_l|| is at most that of a, for both sets. The rotated points have
                // an error of about 4 EPSILON, which is multiplied by l for degree l.
                let tolerance = (2.0 * epsilon + 4.0 * f64::EPSILON * LMAX as f64) * norm(before);
                let energies =
                    before.energy_per_degree().into_iter().zip(after.energy_per_degree());
                for (l, (before, after)) in energies.enumerate() {
                    let change = (after.sqrt() - before.sqrt()).abs();
                    assert!(
                        change <= tolerance,
                        "{}, {epsilon:e}, {rotation}, l = {l}: E = {before}, rotated {after}",
                        set.name
                    );
                }
            }
        }
    }
}
