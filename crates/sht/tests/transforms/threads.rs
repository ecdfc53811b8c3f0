//! Results do not depend on the number of threads that a transform is divided among.

use glam::DVec3;
use rayon::ThreadPoolBuilder;
use sphvar_sh::Alm;
use sphvar_sht::{FastTransform, FastWorkspace};

use crate::coefficients::random;
use crate::points::{Lcg, all};

/// A degree whose transforms are divided among threads even for few points.
const LMAX: usize = 175;

/// Enough points for several threads to locate: random ones, and crowded ones at several places,
/// whose tiles have points of every thread.
fn sets() -> Vec<Vec<DVec3>> {
    let mut rng = Lcg::new(71);
    let random = rng.directions(20_000);
    let crowded = (0..20_000).map(|k| match k % 4 {
        0 => DVec3::Z,
        1 => (1e-3 * rng.direction() + DVec3::Y).normalize(),
        2 => DVec3::new(-0.6, 0.0, -0.8),
        _ => DVec3::new(1e-9 * rng.signed(), 1e-9 * rng.signed(), -1.0).normalize(),
    });
    let crowded = crowded.collect();
    let few = all(30).into_iter().step_by(4).map(|set| set.points);
    few.chain([random, crowded]).collect()
}

/// The results of every transform with a workspace.
fn transforms(plan: &FastTransform, workspace: &mut FastWorkspace) -> (Vec<Alm>, Vec<Vec<u64>>) {
    let sets = sets();
    let mut rng = Lcg::new(72);
    let weights: Vec<Vec<f64>> = sets.iter().map(|set| rng.signed_numbers(set.len())).collect();
    let weighted = sets.iter().zip(&weights).enumerate();
    let weighted: Vec<(&[DVec3], Option<&[f64]>)> = weighted
        .map(|(i, (points, weights))| (&**points, (i % 3 > 0).then_some(&**weights)))
        .collect();
    let mut alms = vec![random(LMAX, &mut rng); sets.len()];
    plan.adjoint_batch_into(&weighted, workspace, &mut alms);
    let functions: Vec<Alm> = (0..5).map(|_| random(LMAX, &mut rng)).collect();
    let functions: Vec<&Alm> = functions.iter().collect();
    let values = sets.iter().map(|points| {
        let mut values = vec![f64::NAN; 5 * points.len()];
        plan.synthesis_batch_into(&functions, points, workspace, &mut values);
        let mut gradients = vec![DVec3::NAN; points.len()];
        let of_one = &mut values[..points.len()];
        plan.gradient_into(functions[0], points, workspace, of_one, &mut gradients);
        let gradients = gradients.iter().flat_map(|g| g.to_array());
        values.iter().copied().chain(gradients).map(f64::to_bits).collect()
    });
    let values = values.collect();
    (alms, values)
}

#[test]
fn any_number_of_threads_gives_the_same_result() {
    for epsilon in [1e-5, 1e-12] {
        let plan = FastTransform::new(LMAX, epsilon).unwrap();
        let expected = transforms(&plan, &mut FastWorkspace::default());
        let mut workspace = FastWorkspace::parallel();
        for n in [3, 2] {
            let pool = ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let got = pool.install(|| transforms(&plan, &mut workspace));
            assert!(got == expected, "{n} threads, epsilon {epsilon:e}");
        }
    }
}
