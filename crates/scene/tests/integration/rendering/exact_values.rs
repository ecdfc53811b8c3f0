//! Integrals at points where their values are known.

use glam::DVec3;
use sphvar_samplers::Pattern;
use sphvar_scene::{
    Camera, DirectionMode, DirectionPlan, Estimator, Integral, Quad, Scene, View, render,
};

use super::spot::{FAR, Spot, covered_share, form_factor, horizontal, mean_and_error};

const SEED: u64 = 1;
const SIDE: usize = 32;
/// The limit of |z|, exceeded by chance once in 1.7 million comparisons; there are about 15 here.
const Z: f64 = 5.0;

const OPEN: Integral<'static> =
    Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false };
const OPEN_COSINE: Integral<'static> =
    Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: true };

/// Returns mean and standard error of 1024 points with 96 jittered directions each.
fn measured(spot: &Spot, integral: &Integral<'_>) -> (f64, f64) {
    let mode = DirectionMode::Antipodal;
    let plan = DirectionPlan::new(Pattern::Jittered, 96, mode, SEED).unwrap();
    let image = spot.render(integral, Estimator::Ratio, &plan.prepare(0).unwrap(), SIDE);
    assert_eq!(image.n_hits(), SIDE * SIDE);
    mean_and_error(&image.values)
}

fn assert_value(spot: &Spot, integral: &Integral<'_>, exact: f64, label: &str) {
    let (mean, error) = measured(spot, integral);
    // Pixels are up to 1e-7 apart, and the planes that represent infinite ones are finite.
    assert!((mean - exact).abs() < Z * error + 4e-6, "{label}: {mean} +- {error}, exact {exact}");
}

#[test]
fn under_an_open_sky_nothing_is_occluded() {
    let (mean, error) = measured(&Spot::with(Vec::new()), &OPEN);
    assert_eq!((mean, error), (1.0, 0.0));
    assert_value(&Spot::with(Vec::new()), &OPEN_COSINE, 1.0, "cosine");
}

#[test]
fn in_a_closed_box_everything_is() {
    let side = |u: DVec3, v: DVec3, n: DVec3| {
        Quad::new([n - u - v, n + u - v, n + u + v, n - u + v].map(|c| c + 0.9 * DVec3::Z)).unwrap()
    };
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let walls = vec![side(y, z, x), side(y, z, -x), side(x, z, y), side(x, z, -y), side(x, y, z)];
    let spot = Spot::with(walls);
    assert_eq!(measured(&spot, &OPEN), (0.0, 0.0));
    assert_eq!(measured(&spot, &OPEN_COSINE), (0.0, 0.0));
    // Within half a unit there is no surface.
    let near = Integral::AmbientOcclusion { max_distance: 0.5, cosine: false };
    assert_eq!(measured(&spot, &near), (1.0, 0.0));
}

/// Beside an infinite wall half of the sky is visible, at any distance; the ends of the finite wall
/// change it by 1e-6.
#[test]
fn beside_a_wall_half_of_the_sky_is_left() {
    for distance in [1e-3, 1.0, 20.0] {
        let corner = |y: f64, z: f64| DVec3::new(distance, y, z);
        let wall = [corner(-FAR, -1.0), corner(FAR, -1.0), corner(FAR, FAR), corner(-FAR, FAR)];
        let spot = Spot::with(vec![Quad::new(wall).unwrap()]);
        assert_value(&spot, &OPEN, 0.5, "uniform");
        assert_value(&spot, &OPEN_COSINE, 0.5, "cosine");
    }
}

#[test]
fn a_ceiling_covers_its_solid_angle() {
    let (x, y, z) = ([-0.3, 1.7], [0.2, 0.9], 0.8);
    let ceiling = horizontal(x, y, z);
    let spot = Spot::with(vec![ceiling]);
    assert_value(&spot, &OPEN, 1.0 - covered_share(x, y, z), "uniform");
    assert_value(&spot, &OPEN_COSINE, 1.0 - form_factor(&ceiling.corners()), "cosine");
    // Rays of length 1 reach the part within a circle about the foot: all of a small ceiling.
    let small = ([-0.1, 0.2], [-0.15, 0.1], 0.7);
    let spot = Spot::with(vec![horizontal(small.0, small.1, small.2)]);
    let near = |max_distance| Integral::AmbientOcclusion { max_distance, cosine: false };
    assert_value(&spot, &near(0.75), 1.0 - covered_share(small.0, small.1, small.2), "near");
    assert_eq!(measured(&spot, &near(0.69)), (1.0, 0.0));
}

#[test]
fn a_lamp_gives_its_form_factor() {
    let (x, y, z) = ([0.3, 1.2], [-0.4, 0.5], 0.9);
    let mut corners = horizontal(x, y, z).corners();
    let upwards = Quad::new(corners).unwrap();
    corners.reverse();
    let lamp = Quad::new(corners).unwrap();
    let light = |light| Integral::Light { light, albedo: 0.7 };
    let open = Spot::with(Vec::new());
    assert_value(&open, &light(&lamp), 0.7 * form_factor(&corners), "open");
    assert_eq!(measured(&open, &light(&upwards)), (0.0, 0.0), "it shines to the other side");
    // A lamp in the plane of a ceiling still illuminates the point.
    let ceiling = horizontal([-3.0, 3.0], [-3.0, 3.0], z);
    assert_value(&Spot::with(vec![ceiling]), &light(&lamp), 0.7 * form_factor(&corners), "ceiling");
    // A screen half way up hides the part x < 0.8 of the lamp.
    let screen = horizontal([-1.0, 0.4], [-1.0, 1.0], 0.5 * z);
    let rest = horizontal([0.8, x[1]], y, z);
    let expected = 0.7 * form_factor(&rest.corners());
    assert_value(&Spot::with(vec![screen]), &light(&lamp), expected, "screen");
    // A screen hides the lamp at any distance in front of it.
    for below in [0.1, 1e-3, 7.5e-4, 1e-5, 1e-6, 1e-9, 1e-12] {
        let height = z - below * z;
        let cover = horizontal([-3.0, 3.0], [-3.0, 3.0], height);
        assert_eq!(measured(&Spot::with(vec![cover]), &light(&lamp)), (0.0, 0.0), "{below:e}");
        // A screen that covers the part beyond y = 0, directly in front of the lamp.
        let part = horizontal([-3.0, 3.0], [0.0, 3.0], height);
        let rest = form_factor(&horizontal(x, [y[0], 0.0], z).corners());
        assert_value(&Spot::with(vec![part]), &light(&lamp), 0.7 * rest, "part");
    }
    // A surface equally close behind the lamp hides nothing.
    let behind = horizontal([-3.0, 3.0], [-3.0, 3.0], z + 1e-12 * z);
    assert_value(&Spot::with(vec![behind]), &light(&lamp), 0.7 * form_factor(&corners), "behind");
    // A surface beyond the lamp hides nothing.
    let beyond = horizontal([-9.0, 9.0], [-9.0, 9.0], 1.1 * z);
    assert_value(&Spot::with(vec![beyond]), &light(&lamp), 0.7 * form_factor(&corners), "beyond");
}

/// A constant sky gives the albedo times its radiance; a sky `1 + d.z` has
/// `int (1 + cos) cos/pi = 1 + 2/3`.
#[test]
fn irradiance_of_simple_skies() {
    let open = Spot::with(Vec::new());
    let under = |radiance: &(dyn Fn(DVec3) -> f64 + Sync), exact: f64, label: &str| {
        assert_value(&open, &Integral::Irradiance { radiance, albedo: 0.5 }, exact, label);
    };
    under(&|_| 3.0, 1.5, "constant");
    under(&|dir| 1.0 + dir.z, 0.5 * (1.0 + 2.0 / 3.0), "brighter above");
    under(&|dir| if dir.x > 0.0 { 2.0 } else { 0.0 }, 0.5, "half of it");
}

/// A square under an open sky that covers parts of pixels has the value 1 in all of them.
#[test]
fn pixels_count_as_they_are_covered() {
    let scene = Scene::from_quads(vec![horizontal([-1.0, 1.0], [-1.0, 1.0], 0.0)]).unwrap();
    let camera = Camera::look_at(5.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, 0.6).unwrap();
    let plan = DirectionPlan::new(Pattern::Jittered, 96, DirectionMode::Antipodal, SEED).unwrap();
    let view = View::new(&scene, &camera, [4, 4]).unwrap().with_rays_per_side(16).unwrap();
    let image = render(&view, &OPEN, Estimator::Ratio, &plan.prepare(0).unwrap(), &()).unwrap();
    assert_eq!((image.n_hits(), image.mean()), (16, 1.0));
    assert_eq!(image.values, [1.0; 16]);
    // The side of the square is 1 of the 5 tan(0.3) of half the picture; primary rays are at most
    // 1/32 of a pixel off.
    let side = 4.0 / (5.0 * 0.3f64.tan());
    assert!((image.covered_area() / (side * side) - 1.0).abs() < 4.0 / 32.0 / side);
}

/// Spreads equal the integrand's variance over the hemisphere.
#[test]
fn spreads_are_those_of_the_integrand() {
    let (x, y, z) = ([-0.3, 1.7], [0.2, 0.9], 0.8);
    let spot = Spot::with(vec![horizontal(x, y, z)]);
    let n = 96;
    let plan = DirectionPlan::new(Pattern::WhiteNoise, n, DirectionMode::Fresh, SEED).unwrap();
    let image = spot.render(&OPEN, Estimator::Ratio, &plan.prepare(0).unwrap(), SIDE);
    let (mean, error) = mean_and_error(&image.spreads);
    let p = covered_share(x, y, z);
    // The variance of a sample is too small by 1/n.
    let expected = p * (1.0 - p) * (1.0 - 1.0 / n as f64);
    assert!((mean - expected).abs() < Z * error, "{mean} +- {error}, expected {expected}");
    let predicted = image.white_noise_variance(n);
    assert!((predicted - mean / n as f64).abs() < 1e-12, "{predicted}");
}
