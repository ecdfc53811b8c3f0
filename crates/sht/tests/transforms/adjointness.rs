//! Synthesis is the adjoint of the adjoint: `<A w, b> = <w, A* b>`.

use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

use crate::coefficients::{norm, product, random};
use crate::points::{Lcg, Set, all};

/// Maximum defect in units of EPSILON. Rounding errors of sums mostly cancel: the measured maximum
/// is 3.
const ROUNDINGS: f64 = 12.0;

/// Weights and coefficients, and their transforms.
struct Pair {
    weights: Vec<f64>,
    of_weights: Alm,
    alm: Alm,
    of_alm: Vec<f64>,
}

impl Pair {
    fn new(set: &Set, lmax: usize, rng: &mut Lcg) -> Self {
        Self {
            weights: rng.signed_numbers(set.points.len()),
            of_weights: Alm::zeros(lmax).unwrap(),
            alm: random(lmax, rng),
            of_alm: vec![0.0; set.points.len()],
        }
    }

    /// Returns `|<A w, b> - <w, A* b>|` over the larger of `||A w|| ||b||` and `||w|| ||A* b||`:
    /// rounding is relative to the terms of either product, which may cancel.
    fn defect(&self) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (weights, values) = (&self.weights, &self.of_alm);
        let difference = product(&self.of_weights, &self.alm) - dot(weights, values);
        let size = (dot(weights, weights) * dot(values, values)).sqrt();
        let size = size.max(norm(&self.of_weights) * norm(&self.alm));
        if difference == 0.0 { 0.0 } else { difference.abs() / size }
    }
}

#[test]
fn exact() {
    let mut rng = Lcg::new(31);
    for lmax in [0, 1, 2, 17, 100] {
        let transform = ExactTransform::new(lmax).unwrap();
        let mut workspace = ExactWorkspace::default();
        for set in all(150) {
            let mut pair = Pair::new(&set, lmax, &mut rng);
            transform.adjoint_into(
                &set.points,
                Some(&pair.weights),
                &mut workspace,
                &mut pair.of_weights,
            );
            transform.synthesis_into(&pair.alm, &set.points, &mut workspace, &mut pair.of_alm);
            let defect = pair.defect();
            let tolerance = ROUNDINGS * f64::EPSILON;
            assert!(defect <= tolerance, "lmax {lmax}, {}: {defect:e}", set.name);
        }
    }
}

#[test]
fn fast() {
    // The steps are exact transposes for any epsilon: only the rounding of grid numbers remains.
    let (single, double) = (f64::from(f32::EPSILON), f64::EPSILON);
    for (epsilon, rounding) in [
        (1e-3, single),
        (1e-5, single),
        (1e-6, single),
        (1e-7, double),
        (1e-10, double),
        (1e-13, double),
    ] {
        let mut rng = Lcg::new(32);
        for lmax in [0, 1, 2, 17, 100] {
            let plan = FastTransform::new(lmax, epsilon).unwrap();
            let mut workspace = FastWorkspace::default();
            for set in all(150) {
                let mut pair = Pair::new(&set, lmax, &mut rng);
                plan.adjoint_into(
                    &set.points,
                    Some(&pair.weights),
                    &mut workspace,
                    &mut pair.of_weights,
                );
                plan.synthesis_into(&pair.alm, &set.points, &mut workspace, &mut pair.of_alm);
                let defect = pair.defect();
                assert!(
                    defect <= ROUNDINGS * rounding,
                    "epsilon {epsilon:e}, lmax {lmax}, {}: {defect:e}",
                    set.name
                );
            }
        }
    }
}
