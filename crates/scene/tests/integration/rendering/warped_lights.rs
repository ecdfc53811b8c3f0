//! Importance sampling of lights, also in extreme positions.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_integrands::Heuristic;
use sphvar_samplers::Pattern;
use sphvar_scene::{
    CornellBox, Density, DirectionMode, DirectionPlan, Estimator, Image, Integral, LightMap, Quad,
    View, render,
};

use super::spot::{Spot, form_factor, horizontal, mean_and_error};
use super::warped::{Z, assert_value, light, one, picture, several};

/// The integral over a lamp for a surface that reflects 0.7.
fn integral(light: &Quad) -> Integral<'_> {
    Integral::Light { light, albedo: 0.7 }
}

#[test]
fn a_lamp_gives_its_form_factor() {
    let down = |x: [f64; 2], y: [f64; 2], z: f64| {
        let mut corners = horizontal(x, y, z).corners();
        corners.reverse();
        Quad::new(corners).unwrap()
    };
    let lamp = down([0.3, 1.2], [-0.4, 0.5], 0.9);
    let exact = 0.7 * form_factor(&lamp.corners());
    let open = Spot::with(Vec::new());
    let maps = [LightMap::Automatic, LightMap::Triangles];
    for map in maps {
        let of = |n| one("sobol", light(lamp, map), n);
        of(1).check(&integral(&lamp)).unwrap();
        for n in [1, 16, 33] {
            assert_value(&open, &integral(&lamp), &of(n), exact, &format!("{map:?} {n}"));
        }
        // A screen half way up hides the part x < 0.8 of the lamp.
        let screen = Spot::with(vec![horizontal([-1.0, 0.4], [-1.0, 1.0], 0.45)]);
        let rest = 0.7 * form_factor(&horizontal([0.8, 1.2], [-0.4, 0.5], 0.9).corners());
        assert_value(&screen, &integral(&lamp), &of(16), rest, &format!("{map:?} screen"));
        // A lamp that stands on the floor and reaches below it.
        let corner = |y: f64, z: f64| DVec3::new(1.0, y, z);
        let wall =
            |z0: f64| [corner(-1.0, z0), corner(-1.0, 1.0), corner(2.0, 1.0), corner(2.0, z0)];
        let standing = Quad::new(wall(-0.7)).unwrap();
        assert!(standing.normal().x < 0.0);
        let plan = one("jittered-square", light(standing, map), 16);
        let exact = 0.7 * form_factor(&wall(0.0));
        assert_value(&open, &integral(&standing), &plan, exact, &format!("{map:?} standing"));
        // Nearly 2 pi steradian.
        let near = down([-40.0, 50.0], [-60.0, 30.0], 1e-3);
        let plan = one("jittered-square", light(near, map), 64);
        let exact = 0.7 * form_factor(&near.corners());
        assert_value(&open, &integral(&near), &plan, exact, &format!("{map:?} near"));
        // A lamp of 1e-12 steradian: its area times two cosines over pi d^2, to 1e-11.
        let (size, center) = (1e-5, DVec3::new(3.0, 2.0, 1.0));
        let side = |x: f64| [x - 0.5 * size, x + 0.5 * size];
        let far = down(side(center.x), side(center.y), center.z);
        let plan = one("jittered-square", light(far, map), 4);
        let exact = 0.7 * far.area() * center.z.powi(2) / (PI * center.length_squared().powi(2));
        assert_value(&open, &integral(&far), &plan, exact, &format!("{map:?} far"));
    }
    // A trapezoid is no rectangle, and one of its triangles may have no area.
    for top in [0.2, -0.8] {
        let corners = [[-0.8, 0.1], [top, 0.9], [0.7, 0.9], [1.3, 0.1]];
        let lamp = Quad::new(corners.map(|[x, y]| DVec3::new(x, y, 0.9))).unwrap();
        assert!(lamp.normal().z < 0.0);
        let plan = one("sobol", light(lamp, LightMap::Automatic), 16);
        let exact = 0.7 * form_factor(&lamp.corners());
        assert_value(&open, &integral(&lamp), &plan, exact, "trapezoid");
    }
}

/// Points behind a lamp, in its plane, or that see it edge-on receive exactly nothing.
#[test]
fn lamps_that_a_point_does_not_see() {
    let open = Spot::with(Vec::new());
    let quad = |corners: [[f64; 3]; 4]| Quad::new(corners.map(DVec3::from_array)).unwrap();
    let lamps = [
        ("behind", horizontal([0.3, 1.2], [-0.4, 0.5], 0.9)),
        ("in its plane", horizontal([0.3, 1.2], [-0.4, 0.5], 0.0)),
        ("edge-on", quad([[0.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 2.0, 2.0], [0.0, 2.0, 1.0]])),
        ("below", quad([[1.0, 0.0, -3.0], [1.0, 0.0, -2.0], [1.0, 1.0, -2.0], [1.0, 1.0, -3.0]])),
        ("remote", horizontal([0.0, 1e-90], [1e-90, 0.0], 1e90)),
    ];
    for (name, lamp) in lamps {
        let integral = Integral::Light { light: &lamp, albedo: 1.0 };
        for map in [LightMap::Automatic, LightMap::Triangles] {
            let image = picture(&open, &integral, &one("sobol", light(lamp, map), 8));
            // The pixels beside an edge-on lamp see it under 1e-7 radians.
            assert!(image.values.iter().all(|v| (0.0..1e-7).contains(v)), "{name} {map:?}");
            assert!(image.values.iter().all(|v| *v == 0.0) || name == "edge-on", "{name} {map:?}");
            // Another density is unaffected by one that is 0.
            let both = vec![(light(lamp, map), 0.5), (Density::cosine(), 0.5)];
            let image = picture(&open, &integral, &several("sobol", both, 16, Heuristic::Power));
            assert!(image.values.iter().all(|v| *v < 1e-3), "{name} {map:?}");
        }
    }
}

/// The mean of many renders of the Cornell box is that by uniform directions, and at equal N the
/// light's own directions have a far smaller error.
#[test]
fn the_light_of_the_cornell_box() {
    let cornell = CornellBox::new();
    let view = View::new(&cornell.scene, &cornell.camera, [6, 6]).unwrap();
    let integral = Integral::Light { light: &cornell.light, albedo: 1.0 };
    let means = |image: &dyn Fn(u64) -> Image| -> Vec<f64> {
        (0..32).map(|number| image(number).mean()).collect()
    };
    let uniform = DirectionPlan::new(Pattern::Jittered, 150, DirectionMode::Antipodal, 1).unwrap();
    let (reference, reference_error) = mean_and_error(&means(&|number| {
        let sets = uniform.prepare(number).unwrap();
        render(&view, &integral, Estimator::Ratio, &sets, &()).unwrap()
    }));
    for map in [LightMap::Automatic, LightMap::Triangles] {
        let plan = one("jittered-square", light(cornell.light, map), 144);
        let (mean, error) = mean_and_error(&means(&|number| {
            let sets = plan.prepare(number).unwrap();
            render(&view, &integral, Estimator::Ratio, &sets, &()).unwrap()
        }));
        let sigma = reference_error.hypot(error);
        assert!((mean - reference).abs() < Z * sigma, "{map:?}: {mean} {reference} +- {sigma}");
        // The ratio of the standard errors is about 10, known to 18 %.
        assert!(3.0 * error < reference_error, "{map:?}: {error:e} {reference_error:e}");
    }
}
