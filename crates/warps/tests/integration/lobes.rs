use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_warps::{Error, PhongLobe, UniformCap, VonMisesFisherLobe, Warp};

use crate::subjects::{edge_points, points};

#[test]
fn lobes_of_every_sharpness_are_inverted() {
    let mut lobes: Vec<Box<dyn Warp>> = Vec::new();
    for sharpness in [0.0, 5e-324, 1e-300, 1e-16, 1e-3, 1.0, 20.0, 1e3, 1e8] {
        lobes.push(Box::new(PhongLobe::new(sharpness).unwrap()));
        lobes.push(Box::new(VonMisesFisherLobe::new(sharpness).unwrap()));
    }
    for lobe in lobes {
        for [u, v] in points(1000) {
            let [got_u, got_v] = lobe.inverse(lobe.map([u, v])).unwrap();
            let error = (got_u - u).abs().max((got_v - v).abs());
            assert!(error < 4e-15, "{lobe:?}: {u}, {v} became {got_u}, {got_v}");
        }
        for point in edge_points() {
            let sample = lobe.sample(point);
            assert!((sample.point.length() - 1.0).abs() < 1e-15, "{lobe:?}: {point:?}");
            assert!(sample.density.is_finite(), "{lobe:?}: {point:?}");
        }
    }
}

/// Below kappa = 1e-16 the lobe is the uniform sphere.
#[test]
fn the_von_mises_fisher_lobe_is_continuous_at_0() {
    let uniform = VonMisesFisherLobe::new(0.0).unwrap();
    for kappa in [5e-324, 1e-300, 1e-17] {
        let lobe = VonMisesFisherLobe::new(kappa).unwrap();
        for point in points(100) {
            let (a, b) = (lobe.sample(point), uniform.sample(point));
            assert!(a.point.distance(b.point) < 1e-14, "{kappa}: {a:?}, {b:?}");
            assert!((a.density * 4.0 * PI - 1.0).abs() < 1e-15, "{kappa}: {a:?}");
        }
    }
}

/// Both lobes tend to the Gaussian of variance 1/kappa, and half of it is within 2 ln(2)/kappa.
#[test]
fn sharp_lobes_are_gaussian() {
    let lobes: [Box<dyn Warp>; 2] =
        [Box::new(PhongLobe::new(1e8).unwrap()), Box::new(VonMisesFisherLobe::new(1e8).unwrap())];
    for lobe in lobes {
        let dir = lobe.map([0.5, 0.0]);
        let expected = (2.0 * 2.0f64.ln() / 1e8).sqrt();
        assert!((dir.x / expected - 1.0).abs() < 2e-8, "{lobe:?}: {dir}");
        assert!((lobe.density(DVec3::Z) * TAU / 1e8 - 1.0).abs() < 2e-8, "{lobe:?}");
    }
}

#[test]
fn caps_down_to_the_smallest_are_inverted() {
    for half_angle in [1e-150, 1e-9, 1e-3, 1.0, 3.0, PI] {
        let cap = UniformCap::new(half_angle).unwrap();
        for [u, v] in points(1000) {
            let dir = cap.map([u, v]);
            let [got_u, got_v] = cap.inverse(dir).unwrap();
            let error = (got_u - u).abs().max((got_v - v).abs());
            assert!(error < 2e-15, "{half_angle}: {u}, {v} became {got_u}, {got_v}");
            assert!(
                dir.x.hypot(dir.y).atan2(dir.z) <= half_angle * (1.0 + 1e-15),
                "{half_angle}: {dir}"
            );
        }
        let solid_angle = 1.0 / cap.density(DVec3::Z);
        let sine = (0.5 * half_angle).sin();
        assert!((solid_angle / (4.0 * PI * sine * sine) - 1.0).abs() < 1e-15, "{half_angle}");
    }
}

#[test]
fn parameters_out_of_range_are_errors() {
    for value in [-1.0, 1.1e8, f64::NAN, f64::INFINITY] {
        let errors = [
            PhongLobe::new(value).unwrap_err(),
            VonMisesFisherLobe::new(value).unwrap_err(),
            UniformCap::new(value).unwrap_err(),
        ];
        for error in errors {
            assert!(matches!(error, Error::Parameter { .. }), "{error}");
        }
    }
    assert!(UniformCap::new(0.0).is_err());
    let text = PhongLobe::new(-1.0).unwrap_err().to_string();
    assert_eq!(text, "exponent must be in [0, 1e8], got -1");
}
