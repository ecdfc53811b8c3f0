use glam::DVec3;
use sphvar_warps::{Error, SphericalRectangle, Warp};

use crate::subjects::{edge_points, points};

/// The solid angle between 0 and (x, y) at distance z; four of them cancel for small rectangles.
fn corner_angle(x: f64, y: f64, z: f64) -> f64 {
    (x * y).atan2(z * (x * x + y * y + z * z).sqrt())
}

/// The rectangle [x0, x1] x [y0, y1] at z.
fn rectangle(x: [f64; 2], y: [f64; 2], z: f64) -> SphericalRectangle {
    let corner = DVec3::new(x[0], y[0], z);
    SphericalRectangle::new(corner, (x[1] - x[0]) * DVec3::X, (y[1] - y[0]) * DVec3::Y).unwrap()
}

#[test]
fn solid_angles_are_those_of_four_corners() {
    for (x, y, z) in [
        ([-1.0, 1.0], [-1.0, 1.0], 1.0),
        ([2.0, 5.0], [-3.0, -1.0], 0.5),
        ([-5.0, -2.0], [-3.0, 1.0], 2.0),
        ([-1e6, 1e6], [-1e6, 1e6], 1.0),
        ([0.0, 1.0], [0.0, 1e-3], 1e-3),
    ] {
        let expected =
            corner_angle(x[1], y[1], z) - corner_angle(x[0], y[1], z) - corner_angle(x[1], y[0], z)
                + corner_angle(x[0], y[0], z);
        let got = rectangle(x, y, z).solid_angle();
        assert!(
            (got - expected).abs() < 2e-15 * (1.0 + expected),
            "{x:?}, {y:?}: {got}, not {expected}"
        );
    }
}

/// u divides the solid angle: the part of the rectangle before x has the fraction u.
#[test]
fn a_rectangle_is_divided_in_proportion() {
    for (x, y, z) in [
        ([-1.0, 1.0], [-1.0, 1.0], 1.0),
        ([-5.0, -2.0], [-3.0, 1.0], 2.0),
        ([2.0, 5.0], [-3.0, -1.0], 1e-3),
        ([100.0, 101.0], [200.0, 201.0], 50.0),
    ] {
        let whole = rectangle(x, y, z);
        for u in [0.01, 0.3, 0.5, 0.99] {
            let dir = whole.map([u, 0.4]);
            let at = dir.x / dir.z * z;
            let share = rectangle([x[0], at], y, z).solid_angle() / whole.solid_angle();
            assert!((share - u).abs() < 1e-12, "{x:?}, {y:?}, {z}: {u} is {share}");
        }
    }
}

#[test]
fn rectangles_of_every_size_are_inverted() {
    for size in [1e-7, 1e-5, 1e-2, 1.0, 100.0] {
        for [x, y] in [[0.0, 0.0], [-0.5, -0.5], [0.7, -2.0], [-3.0, 2.0]] {
            let warp = rectangle([x, x + size], [y, y + size], 1.0);
            assert_inverted(&warp, 1e-14 + 4e-15 / size);
        }
    }
}

/// Seen at an angle of `z`, from the side and from a point just above the rectangle.
#[test]
fn rectangles_seen_edge_on_are_inverted() {
    for z in [1e-3, 1e-6, 1e-9] {
        let warp = rectangle([1.0, 2.0], [-1.0, 1.0], z);
        // From the side the solid angle is the integral of z/r^3 to first order in z.
        let side = |x: f64| (1.0 + x * x).sqrt() / x;
        let expected = 2.0 * z * (side(1.0) - side(2.0));
        assert!((warp.solid_angle() / expected - 1.0).abs() < z, "{z}: {}", warp.solid_angle());
        assert_inverted(&warp, 1e-14 + 4e-15 / z);
        assert_inverted(&rectangle([-1.0, 2.0], [-1.0, 1.0], z), 1e-13);
    }
}

fn assert_inverted(warp: &SphericalRectangle, tolerance: f64) {
    for [u, v] in points(500) {
        let dir = warp.map([u, v]);
        let [got_u, got_v] = warp.inverse(dir).unwrap_or_else(|| panic!("{warp:?}: {u}, {v}"));
        let error = (got_u - u).abs().max((got_v - v).abs());
        assert!(error < tolerance, "{warp:?}: {u}, {v} became {got_u}, {got_v}");
    }
    for point in edge_points() {
        let dir = warp.map(point);
        assert!((dir.length() - 1.0).abs() < 1e-15, "{warp:?}: {point:?}");
        assert!(warp.density(dir) > 0.0, "{warp:?}: {point:?}");
    }
}

#[test]
fn rectangles_without_solid_angle_are_errors() {
    let corner = DVec3::new(1.0, 1.0, 0.0);
    let cases = [
        (corner, DVec3::X, DVec3::Y),
        (corner + DVec3::Z, DVec3::X, DVec3::ZERO),
        (corner + DVec3::Z, DVec3::X, DVec3::new(0.1, 1.0, 0.0)),
        (corner + DVec3::Z, DVec3::X, DVec3::NAN),
        (DVec3::INFINITY, DVec3::X, DVec3::Y),
    ];
    for (corner, u, v) in cases {
        let result = SphericalRectangle::new(corner, u, v);
        assert!(matches!(result, Err(Error::Degenerate { .. })), "{corner}, {u}, {v}: {result:?}");
    }
}
