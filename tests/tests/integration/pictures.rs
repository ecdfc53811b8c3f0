//! Pixels of a picture are unbiased estimates with the variance that spectra predict.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_integrands::{ClampedCosine, Integrand};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_scene::{
    Camera, DirectionMode, DirectionPlan, Estimator, Image, Integral, Quad, Scene, View, render,
};
use sphvar_spectrum::estimate;
use sphvar_tests::Family;
use sphvar_variance::{Measurement, predict};

const SEED: u64 = 10;
/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;
const SIDE: usize = 64;

/// Under an open sky, weighted with the cosine: the integral of the cosine over pi, which is 1.
const COSINE: Integral<'static> =
    Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: true };

/// Every pixel shows the same point of an open floor and is a replication.
fn picture(plan: &DirectionPlan, estimator: Estimator) -> Image {
    let floor = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let floor = Quad::new(floor.map(|[x, y]| DVec3::new(x, y, 0.0))).unwrap();
    let scene = Scene::from_quads(vec![floor]).unwrap();
    let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, 1e-6).unwrap();
    let view = View::new(&scene, &camera, [SIDE, SIDE]).unwrap();
    render(&view, &COSINE, estimator, &plan.prepare(0).unwrap(), &()).unwrap()
}

fn plan(pattern: &Pattern, requested: usize, mode: DirectionMode) -> DirectionPlan {
    let n = DirectionPlan::nearest_count(pattern, requested, mode);
    DirectionPlan::new(pattern.clone(), n, mode, SEED).unwrap()
}

/// With a realization for each pixel; lattices have only one, which every pixel rotates.
#[test]
fn the_variance_of_a_pixel_is_the_predicted_one() {
    const LMAX: usize = 60;
    let energy = ClampedCosine.energy(Domain::Hemisphere, LMAX).unwrap();
    let mut family = Family::new("variance of a pixel");
    for pattern in Pattern::ELEMENTARY {
        for requested in [24, 96] {
            let plan = plan(&pattern, requested, DirectionMode::Fresh);
            let sampler = pattern.build(plan.n_points(), Domain::Hemisphere).unwrap();
            let streams = Streams::new(SEED, Purpose::Pattern, plan.n_points());
            let sets = Realizations::rotated(&*sampler, streams);
            let predicted = predict(&estimate(&sets, LMAX, 300, &()).unwrap(), &energy);
            // The value of a pixel is the integral over pi.
            let got = Measurement::new(picture(&plan, Estimator::Ratio).values);
            let (expected, error) = (predicted.variance / (PI * PI), predicted.stderr / (PI * PI));
            let stderr = got.variance_stderr().hypot(error);
            family.compare(got.variance(), expected, stderr, || format!("{pattern} {requested}"));
        }
    }
    family.assert_null(ALPHA);
}

/// Halves of sphere sets use their sum, antipodal sets either estimate.
#[test]
#[ignore = "statistics"]
fn rotated_directions_have_no_bias() {
    let mut family = Family::new("mean of pixels");
    for pattern in Pattern::ALL {
        for mode in [DirectionMode::Rotated, DirectionMode::Antipodal] {
            let values = picture(&plan(&pattern, 24, mode), Estimator::Unbiased).values;
            let got = Measurement::new(values);
            family.compare(got.mean(), 1.0, got.mean_stderr(), || format!("{pattern} {mode}"));
        }
    }
    family.assert_null(ALPHA);
}
