use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_warps::{Error, SphericalTriangle, UniformCap, Warp};

use crate::subjects::{edge_points, points};

/// The solid angle from the dihedral angles (Girard), which loses digits for small triangles.
fn girard(vertices: [DVec3; 3]) -> f64 {
    let [a, b, c] = vertices.map(DVec3::normalize);
    let angle = |x: DVec3, y: DVec3, z: DVec3| x.cross(y).angle_between(x.cross(z));
    angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - PI
}

#[test]
fn solid_angles_are_those_of_girard() {
    let directions: Vec<_> = points(60).map(|point| UniformCap::SPHERE.map(point)).collect();
    for vertices in directions.as_chunks().0.iter().copied() {
        let triangle = SphericalTriangle::new(vertices).unwrap();
        let (got, expected) = (triangle.solid_angle(), girard(vertices));
        assert!((got - expected).abs() < 1e-13, "{vertices:?}: {got}, not {expected}");
    }
}

#[test]
fn the_octant_is_one_of_the_triangles() {
    let octant = SphericalTriangle::new([DVec3::X, DVec3::Z, DVec3::Y]).unwrap();
    for [u, v] in points(100) {
        let (a, b) = (SphericalTriangle::OCTANT.sample([u, v]), octant.sample([u, v]));
        assert!(a.point.distance(b.point) < 1e-15 && (a.density - b.density).abs() < 1e-15);
        assert!((a.point.z - (1.0 - v)).abs() < 1e-15, "{u}, {v}: {a:?}");
        assert!((a.point.y.atan2(a.point.x) - 0.5 * PI * u).abs() < 1e-14, "{u}, {v}: {a:?}");
    }
}

/// The map is uniform: the triangle A, B, D has the fraction u, the part next to B the fraction v
/// of a sliver between arcs through B.
#[test]
fn a_triangle_is_divided_in_proportion() {
    for vertices in [
        [DVec3::X, DVec3::Y, DVec3::new(0.1, 0.2, 1.0)],
        [DVec3::new(1.0, 0.0, 1e-4), DVec3::new(-0.5, 0.8, 1e-4), DVec3::new(-0.5, -0.9, 1e-4)],
        [DVec3::Z, DVec3::new(1e-5, 0.0, 1.0), DVec3::new(0.0, 1e-5, 1.0)],
    ] {
        let triangle = SphericalTriangle::new(vertices).unwrap();
        for u in [0.1, 0.5, 0.9] {
            let d = triangle.map([u, 1.0f64.next_down()]);
            let part = SphericalTriangle::new([vertices[0], vertices[1], d]).unwrap();
            let share = part.solid_angle() / triangle.solid_angle();
            // D is known to EPSILON/1e-5 of the smallest triangle.
            assert!((share - u).abs() < 1e-10, "{vertices:?}, {u}: {share}");
        }
    }
}

#[test]
fn triangles_of_every_size_are_inverted() {
    for size in [1e-7, 1e-6, 1e-4, 1e-2, 1.0] {
        for pole in [DVec3::Z, DVec3::new(0.3, -0.5, 0.8).normalize()] {
            let (x, y) = pole.any_orthonormal_pair();
            let triangle =
                SphericalTriangle::new([pole, pole + size * x, pole + size * y]).unwrap();
            if size < 0.1 {
                let expected = 0.5 * size * size;
                let error = (triangle.solid_angle() / expected - 1.0).abs();
                assert!(error < size * size + 1e-15 / size, "{size}: {error}");
            }
            assert_inverted(&triangle, 4e-15 / size);
        }
    }
}

/// E = 2 pi - 1e-6 and nearer; the rounding of vertices is magnified by the distance from 2 pi.
#[test]
fn triangles_of_nearly_2_pi_are_inverted() {
    for height in [1e-2, 1e-6, 1e-9] {
        let vertex = |phi: f64| DVec3::new(phi.cos(), phi.sin(), height);
        let triangle = SphericalTriangle::new([0.3, 2.5, 4.6].map(vertex)).unwrap();
        assert!(TAU - triangle.solid_angle() < 20.0 * height, "{height}");
        assert_inverted(&triangle, 1e-14 / height);
    }
}

fn assert_inverted(triangle: &SphericalTriangle, tolerance: f64) {
    for [u, v] in points(1000) {
        let dir = triangle.map([u, v]);
        let [got_u, got_v] =
            triangle.inverse(dir).unwrap_or_else(|| panic!("{triangle:?}: {u}, {v}"));
        // Near B, which all u share, the error of u grows as the reciprocal of the distance.
        let error = ((got_u - u).abs() * v.sqrt()).max((got_v - v).abs());
        assert!(error < tolerance, "{triangle:?}: {u}, {v} became {got_u}, {got_v}");
    }
    for point in edge_points() {
        let dir = triangle.map(point);
        assert!((dir.length() - 1.0).abs() < 1e-15, "{triangle:?}: {point:?}");
        assert!(triangle.density(dir) > 0.0, "{triangle:?}: {point:?}");
    }
}

#[test]
fn triangles_without_solid_angle_are_errors() {
    let cases = [
        [DVec3::X, DVec3::X, DVec3::Y],
        [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)],
        [DVec3::X, -DVec3::X, DVec3::Y],
        [DVec3::ZERO, DVec3::X, DVec3::Y],
        [DVec3::NAN, DVec3::X, DVec3::Y],
        [DVec3::INFINITY, DVec3::X, DVec3::Y],
    ];
    for vertices in cases {
        let result = SphericalTriangle::new(vertices);
        assert!(matches!(result, Err(Error::Degenerate { .. })), "{vertices:?}: {result:?}");
    }
}
