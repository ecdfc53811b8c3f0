//! Stated errors of pulled-back integrands against their distribution.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_integrands::{Cap, Domain, Integrand, PulledBack, Rotated, SquareIntegrand, Tolerance};
use sphvar_sh::{Frequencies, TailClasses};
use sphvar_warps::{CosineHemisphere, OctahedralSphere, UniformCap, Warp};

fn pull<'a>(
    f: &'a dyn Integrand,
    domain: Domain,
    warp: Arc<dyn Warp>,
    max: usize,
) -> PulledBack<'a> {
    let tolerance = Tolerance { relative: 1e-6, min_evaluations: 1 << 14, max_evaluations: max };
    PulledBack::new(f, domain, warp, tolerance).unwrap()
}

/// Jittered points with random shifts, whose power is 1 - sinc^2(k1/n) sinc^2(k2/n).
#[test]
fn energies_predict_measured_variances() {
    let f = |dir: DVec3| (3.0 * dir.x).exp() * dir.z * f64::from(dir.y < 0.4);
    let g = pull(&f, Domain::Hemisphere, Arc::new(CosineHemisphere), 1 << 18);
    let (n, trials) = (4, 4000);
    let bands = Frequencies::new(64).unwrap().with_axes(512).unwrap();
    let energy = g.energy(&bands).unwrap();
    let sinc = |k: i32| {
        let x = PI * f64::from(k) / f64::from(n);
        if k == 0 { 1.0 } else { x.sin() / x }
    };
    let term = |band: usize| {
        let [k1, k2] = bands.frequency(band);
        energy.per_band()[band] * (1.0 - (sinc(k1) * sinc(k2)).powi(2))
    };
    let sum: f64 = (1..bands.len()).map(term).sum();
    let predicted = (sum + energy.beyond(bands.len() - 1)) / f64::from(n * n);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let estimates: Vec<f64> = (0..trials)
        .map(|_| {
            let shift: [f64; 2] = [rng.random(), rng.random()];
            let mut sum = 0.0;
            for cell in 0..n * n {
                let place = |i: i32, jitter: f64, shift: f64| {
                    ((f64::from(i) + jitter) / f64::from(n) + shift).fract()
                };
                let u = place(cell / n, rng.random(), shift[0]);
                sum += g.eval([u, place(cell % n, rng.random(), shift[1])]);
            }
            sum / f64::from(n * n)
        })
        .collect();
    let count = f64::from(trials);
    let mean = estimates.iter().sum::<f64>() / count;
    let moment = |p: i32| estimates.iter().map(|x| (x - mean).powi(p)).sum::<f64>() / count;
    let (variance, fourth) = (moment(2), moment(4));
    let stderr = ((fourth - variance * variance) / count).sqrt();
    // False alarms: 6e-7 for 5 standard errors.
    assert!((variance - predicted).abs() < 5.0 * stderr, "{variance} +- {stderr}, {predicted}");
}

/// Stated errors of energies are the largest of three deviations, which exceeds a fourth one of the
/// same distribution in 75 % of the cases. The true deviation is taken from energies of 40 times as
/// many values. 79 % of the 2700 bands were covered; the seed is fixed, so there are no false alarms.
#[test]
#[ignore = "statistics"]
fn stated_errors_cover_deviations() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let bands = Frequencies::new(8).unwrap();
    let (mut covered, mut all) = (0, 0);
    for i in 0..24 {
        let cap = Cap::from_degrees(rng.random_range(20.0..80.0)).unwrap();
        let angles: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.0..TAU));
        let rotation = DQuat::from_rotation_z(angles[0])
            * DQuat::from_rotation_x(angles[1])
            * DQuat::from_rotation_z(angles[2]);
        let cap = Rotated::new(cap, rotation).unwrap();
        // A closure, so that neither the edge nor the variance is known.
        let hidden = |dir: DVec3| cap.eval(dir);
        let warp: Arc<dyn Warp> =
            if i % 2 == 0 { Arc::new(UniformCap::SPHERE) } else { Arc::new(OctahedralSphere) };
        let energy =
            |max: usize| pull(&hidden, Domain::Sphere, warp.clone(), max).energy(&bands).unwrap();
        let (coarse, fine) = (energy(50_000), energy(2_000_000));
        let errors = coarse.per_band_stderr().unwrap();
        for (band, error) in errors.iter().enumerate().skip(1) {
            all += 1;
            covered += i32::from((coarse.per_band()[band] - fine.per_band()[band]).abs() <= *error);
        }
        let deviation = (coarse.centred().sum() - fine.centred().sum()).abs();
        let error = coarse.centred_stderr().sum();
        assert!(deviation < 5.0 * error, "{deviation} and {error}");
    }
    let share = f64::from(covered) / f64::from(all);
    assert!(share > 0.7, "{share}");
}
