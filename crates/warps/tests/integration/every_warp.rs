use glam::DVec3;
use sphvar_warps::{Measure, Support, UniformCap, Warp};

use crate::subjects::{all, edge_points, points};

/// The distance on a circle of length 1, for longitudes at the seam.
fn distance(x: f64, y: f64) -> f64 {
    let difference = (x - y).abs();
    difference.min(1.0 - difference)
}

#[test]
fn round_trips_return_the_point() {
    for (name, warp) in all() {
        for [u, v] in points(2000) {
            let sample = warp.sample([u, v]);
            let [got_u, got_v] =
                warp.inverse(sample.point).unwrap_or_else(|| panic!("{name}: {u}, {v}"));
            let error = (got_u - u).abs().max(distance(got_v, v));
            assert!(error <= 1e-12, "{name}: {u}, {v} became {got_u}, {got_v}");
        }
    }
}

#[test]
fn samples_are_unit_vectors_of_positive_density_on_the_whole_square() {
    for (name, warp) in all() {
        for point in points(2000).chain(edge_points()) {
            let sample = warp.sample(point);
            assert_eq!(warp.map(point), sample.point, "{name}: {point:?}");
            match warp.measure() {
                Measure::SolidAngle => {
                    let error = (sample.point.length() - 1.0).abs();
                    assert!(error < 1e-15, "{name}: {point:?} has length 1 + {error:e}");
                }
                Measure::DiskArea => {
                    assert!(sample.point.length() <= 1.0 + 1e-15, "{name}: {point:?}");
                }
            }
            let min = warp.min_density();
            assert!(sample.density >= min * (1.0 - 1e-14), "{name}: {point:?}: {sample:?}, {min}");
            if warp.support() == Support::UpperHemisphere {
                assert!(sample.point.z >= 0.0, "{name}: {point:?}: {sample:?}");
            }
        }
    }
}

#[test]
fn the_density_of_a_sample_is_that_of_its_direction() {
    for (name, warp) in all() {
        for point in points(2000) {
            let sample = warp.sample(point);
            let density = warp.density(sample.point);
            let error = (density / sample.density - 1.0).abs();
            // The map of 100 next to 1 multiplies the rounding of longitudes by 100 columns.
            assert!(error < 1e-12, "{name}: {point:?}: {sample:?}, not {density}");
        }
    }
}

#[test]
fn inverses_are_in_the_square_and_exist_where_the_density_is_positive() {
    for (name, warp) in all() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let sphere = points(3000).map(|point| UniformCap::SPHERE.map(point));
        let on_edges = edge_points().into_iter().map(|point| warp.map(point));
        for dir in sphere.chain(axes).chain(axes.map(|x| -x)).chain(on_edges) {
            let density = warp.density(dir);
            assert!(density >= 0.0 && density.is_finite(), "{name}: {dir}: {density}");
            match warp.inverse(dir) {
                Some(point) => assert!(
                    point.iter().all(|x| (0.0..1.0).contains(x)),
                    "{name}: {dir}: {point:?}"
                ),
                None => assert!(density <= 0.0, "{name}: {dir} has density {density}"),
            }
        }
    }
}

/// 1/|det dT/du| by central differences; their error is about (H/distance to an edge)^2.
#[test]
fn the_density_is_the_reciprocal_of_the_jacobian() {
    const H: f64 = 1e-6;
    const EDGE: f64 = 1e-2;
    for (name, warp) in all() {
        let breaks_in_u = warp.breaks_in_u();
        let mut compared = 0;
        for [u, v] in points(1000) {
            let near =
                |breaks: &[f64], x: f64, gap: f64| breaks.iter().any(|b| (b - x).abs() < gap);
            let is_inside = |x: f64| (EDGE..1.0 - EDGE).contains(&x);
            // Texels are narrower than the edge of the square.
            let gap = if breaks_in_u.len() > 5 { 1e-4 } else { EDGE };
            if !is_inside(u)
                || !is_inside(v)
                || near(&breaks_in_u, u, gap)
                || near(&warp.breaks_in_v(u), v, gap)
            {
                continue;
            }
            let du = (warp.map([u + H, v]) - warp.map([u - H, v])) / (2.0 * H);
            let dv = (warp.map([u, v + H]) - warp.map([u, v - H])) / (2.0 * H);
            let product = du.cross(dv).length() * warp.sample([u, v]).density;
            assert!((product - 1.0).abs() < 1e-4, "{name}: {u}, {v}: {product}");
            compared += 1;
        }
        assert!(compared > 100, "{name}: only {compared} points were compared");
    }
}

#[test]
fn breaks_are_ascending_and_inside() {
    for (name, warp) in all() {
        for breaks in points(50).map(|[u, _]| warp.breaks_in_v(u)).chain([warp.breaks_in_u()]) {
            assert!(breaks.is_sorted_by(|a, b| a < b), "{name}: {breaks:?}");
            assert!(breaks.iter().all(|x| *x > 0.0 && *x < 1.0), "{name}: {breaks:?}");
        }
    }
}

#[test]
fn batches_are_bit_identical_to_single_samples() {
    for (name, warp) in all() {
        let points: Vec<_> = points(37).collect();
        let mut samples = vec![warp.sample([0.1, 0.2]); 3];
        warp.sample_into(&points, &mut samples);
        let single: Vec<_> = points.iter().map(|point| warp.sample(*point)).collect();
        assert_eq!(samples, single, "{name}");
    }
}
