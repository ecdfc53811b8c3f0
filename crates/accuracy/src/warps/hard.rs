use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_warps::{
    ConcentricDisk, CosineHemisphere, DensityMap, Interpolation, Measure, OctahedralSphere,
    PhongLobe, SphericalRectangle, SphericalTriangle, UniformCap, VonMisesFisherLobe, Warp,
};

use super::luminance::Luminance;
use super::subjects::{VALID, distance, points, von_mises_fisher};
use crate::{Errors, HardCase};

const BOTH: [Interpolation; 2] = [Interpolation::Constant, Interpolation::Bilinear];

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "triangle_of_1e_minus_12_steradian",
            what: "relative error of the solid angle of a right triangle, and round trips, times its legs of 1.4e-6",
            bound: 1e-15,
            reason: "the rounding of directions is divided by the legs",
            measure: small_triangle,
        },
        HardCase {
            name: "triangle_of_nearly_2_pi",
            what: "the solid angle 2 pi - 1e-5 of an equilateral triangle, relative to 2 pi, and round trips, times \
                   the height 1e-6 of its vertices over the equator",
            bound: 4e-15,
            reason: "the rounding of directions is divided by the height",
            measure: large_triangle,
        },
        HardCase {
            name: "rectangle_seen_edge_on",
            what: "the solid angle of 7e-10 of a rectangle at 1e-9 from its plane, relative, and round trips, times 1e-9",
            bound: 1e-14,
            reason: "the rounding of directions is divided by their extent",
            measure: edge_on,
        },
        HardCase {
            name: "lobe_of_kappa_1e8",
            what: "relative errors of densities, and round trips, of the von Mises-Fisher lobe of kappa 1e8",
            bound: 2e-14,
            reason: "rounding of the height is multiplied by -ln(1 - u) < 10",
            measure: sharp_lobe,
        },
        HardCase {
            name: "texel_of_1e20",
            what: "relative errors of densities, and round trips, of maps of 64 x 32 texels of 1 but for one of 1e20, \
                   without and with a floor of 0.5; densities below 1e-3 are left out",
            bound: 1e-11,
            reason: "rounding of angles, relative to a texel, is multiplied by up to 1e3 where densities vanish",
            measure: bright_texel,
        },
        HardCase {
            name: "rows_of_zeros",
            what: "round trips in maps with rows and columns of zeros; infinite if a sample has no density",
            bound: 1e-13,
            reason: "rounding of angles, relative to a texel",
            measure: zeros,
        },
        HardCase {
            name: "map_of_one_column",
            what: "longitudes, relative densities and round trips of maps of 1 x 64 texels",
            bound: 1e-13,
            reason: "rounding of angles, relative to a texel",
            measure: one_column,
        },
        HardCase {
            name: "map_of_16384_x_8192_texels",
            what: "relative densities and round trips of a bilinear map of 1.3e8 texels of 1 but for one of 1e6 \
                   (1.2 GB of memory)",
            bound: 1e-10,
            reason: "rounding of angles, relative to a texel, is 1e-12, and steeper next to the bright texel",
            measure: large_map,
        },
        HardCase {
            name: "poles_of_every_map",
            what: "1 - cos of the angle between the poles, and the axes, and the images of their inverses; infinite \
                   unless an inverse exists where the density is positive",
            bound: 4e-15,
            reason: "the coordinate 1 is rounded to 1 - 2^-53, which changes heights by a few roundings",
            measure: poles,
        },
    ]
}

/// Adds errors of round trips, times a factor.
fn push_round_trips(errors: &mut Errors, warp: &dyn Warp, factor: f64) {
    for point in points(1000) {
        let error = distance(point, warp.inverse(warp.map(point)));
        errors.push(error * factor, || format!("{point:?}"));
    }
}

/// Adds errors of round trips in a triangle, which are larger next to the vertex at v = 0.
fn push_triangle(
    errors: &mut Errors,
    triangle: &SphericalTriangle,
    expected: f64,
    scale: f64,
    factor: f64,
) {
    let error = (triangle.solid_angle() - expected) / scale;
    errors.push(error, || "the solid angle".to_owned());
    for [u, v] in points(1000) {
        let inverse = triangle.inverse(triangle.map([u, v]));
        let error =
            inverse.map_or(f64::NAN, |[s, t]| ((s - u) * v.sqrt()).abs().max((t - v).abs()));
        errors.push(error * factor, || format!("[{u}, {v}]"));
    }
}

fn small_triangle() -> Errors {
    let leg = 2.0f64.sqrt() * 1e-6;
    let (sin, cos) = leg.sin_cos();
    let vertices = [DVec3::new(sin, 0.0, cos), DVec3::Z, DVec3::new(0.0, sin, cos)];
    let triangle = SphericalTriangle::new(vertices).expect(VALID);
    let expected = 2.0 * (0.5 * leg).tan().powi(2).atan();
    let mut errors = Errors::default();
    push_triangle(&mut errors, &triangle, expected, expected, leg);
    errors
}

fn large_triangle() -> Errors {
    let height = 1e-6f64;
    let radius = ((1.0 - height) * (1.0 + height)).sqrt();
    let vertex =
        |k: f64| DVec3::new(radius * (k * TAU / 3.0).cos(), radius * (k * TAU / 3.0).sin(), height);
    let triangle = SphericalTriangle::new([0.0, 1.0, 2.0].map(vertex)).expect(VALID);
    // Each angle is pi - 2 atan(sqrt(3) h).
    let expected = TAU - 6.0 * (3.0f64.sqrt() * height).atan();
    let mut errors = Errors::default();
    push_triangle(&mut errors, &triangle, expected, TAU, height);
    errors
}

fn edge_on() -> Errors {
    let z = 1e-9;
    let corner = DVec3::new(1.0, 0.0, z);
    let rectangle = SphericalRectangle::new(corner, DVec3::X, DVec3::Y).expect(VALID);
    // The difference of two rectangles with a corner at the foot of the perpendicular.
    let expected = (z * (2.0 + z * z).sqrt()).atan() - (0.5 * z * (5.0 + z * z).sqrt()).atan();
    let mut errors = Errors::default();
    errors.push(rectangle.solid_angle() / expected - 1.0, || "the solid angle".to_owned());
    push_round_trips(&mut errors, &rectangle, z);
    errors
}

fn sharp_lobe() -> Errors {
    let (lobe, reference) = von_mises_fisher(1e8);
    let mut errors = Errors::default();
    for point in points(1000) {
        let sample = lobe.sample(point);
        for density in [sample.density, lobe.density(sample.point)] {
            errors.push(density / reference(point, sample.point) - 1.0, || format!("{point:?}"));
        }
    }
    push_round_trips(&mut errors, lobe.as_ref(), 1.0);
    errors
}

fn bright_texel() -> Errors {
    let mut errors = Errors::default();
    let mut texels = vec![1.0; 64 * 32];
    texels[10 * 64 + 20] = 1e20;
    for interpolation in BOTH {
        let reference = Luminance::new(64, 32, texels.clone(), interpolation, false);
        let map = DensityMap::new(64, 32, texels.clone(), interpolation).expect(VALID);
        let mixed = map.clone().with_floor(0.5).expect(VALID);
        for (warp, floor) in [(map, 0.0), (mixed, 0.5)] {
            for point in points(1000) {
                let sample = warp.sample(point);
                let expected =
                    (1.0 - floor) * reference.density(sample.point) + floor / (2.0 * TAU);
                // At the foot of the peak the density vanishes.
                if sample.density > 1e-3 {
                    errors.push(sample.density / expected - 1.0, || format!("{point:?}, {floor}"));
                }
            }
            push_round_trips(&mut errors, &warp, 1.0);
        }
    }
    errors
}

fn zeros() -> Errors {
    let mut errors = Errors::default();
    let mut texels = vec![1.0; 64 * 32];
    texels[..5 * 64].fill(0.0);
    texels[15 * 64..18 * 64].fill(0.0);
    texels.chunks_exact_mut(64).for_each(|row| row[10..30].fill(0.0));
    for interpolation in BOTH {
        let map = DensityMap::new(64, 32, texels.clone(), interpolation).expect(VALID);
        let cosine = map.clone().times_cosine().expect(VALID);
        for warp in [map, cosine] {
            let is_sampled = |point: &[f64; 2]| warp.sample(*point).density > 0.0;
            let error = if points(1000).iter().all(is_sampled) { 0.0 } else { f64::INFINITY };
            errors.push(error, || "a density of 0".to_owned());
            push_round_trips(&mut errors, &warp, 1.0);
        }
    }
    errors
}

fn one_column() -> Errors {
    let mut errors = Errors::default();
    let texels: Vec<f64> = (0..64).map(|i| f64::from(1 + i % 5)).collect();
    for interpolation in BOTH {
        let reference = Luminance::new(1, 64, texels.clone(), interpolation, false);
        let warp = DensityMap::new(1, 64, texels.clone(), interpolation).expect(VALID);
        for point in points(1000) {
            let sample = warp.sample(point);
            let expected = reference.density(sample.point);
            errors.push(sample.density / expected - 1.0, || format!("{point:?}"));
            let offset = if interpolation == Interpolation::Bilinear { 0.5 } else { 0.0 };
            let turns = (sample.point.y.atan2(sample.point.x) / TAU - offset).rem_euclid(1.0);
            errors.push(turns - point[1], || format!("longitude of {point:?}"));
        }
        push_round_trips(&mut errors, &warp, 1.0);
    }
    errors
}

fn large_map() -> Errors {
    const WIDTH: usize = 16384;
    const HEIGHT: usize = 8192;
    let mut texels = vec![1.0; WIDTH * HEIGHT];
    let (row, peak) = (HEIGHT / 2, 1e6);
    texels[row * WIDTH + 1000] = peak;
    let warp = DensityMap::new(WIDTH, HEIGHT, texels, Interpolation::Bilinear).expect(VALID);
    // The peak integrates to its excess times a column and a hat over theta: with steps h,
    // sin(theta) (2 sin(h/2)/h)^2 h.
    let step = PI / HEIGHT as f64;
    let hat = ((row as f64 + 0.5) * step).sin() * (2.0 * (0.5 * step).sin()).powi(2) / step;
    let integral = 2.0 * TAU + (peak - 1.0) * hat * TAU / WIDTH as f64;
    let mut errors = Errors::default();
    let direction = |theta: f64, phi: f64| {
        let (sin, cos) = theta.sin_cos();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    let centre = direction((row as f64 + 0.5) * step, TAU * 1000.5 / WIDTH as f64);
    errors.push(warp.density(centre) / peak * integral - 1.0, || "the peak".to_owned());
    errors.push(warp.density(-centre) * integral - 1.0, || "opposite of the peak".to_owned());
    push_round_trips(&mut errors, &warp, 1.0);
    errors
}

fn poles() -> Errors {
    let mut errors = Errors::default();
    let mut warps: Vec<Box<dyn Warp>> = vec![
        Box::new(UniformCap::SPHERE),
        Box::new(UniformCap::HEMISPHERE),
        Box::new(UniformCap::new(1e-9).expect(VALID)),
        Box::new(OctahedralSphere),
        Box::new(CosineHemisphere),
        Box::new(ConcentricDisk),
        Box::new(PhongLobe::new(1.0).expect(VALID)),
        Box::new(VonMisesFisherLobe::new(0.5).expect(VALID)),
        Box::new(SphericalTriangle::OCTANT),
    ];
    // With 5 rows the axes are not on an edge between rows, where constant maps jump.
    for interpolation in BOTH {
        let texels: Vec<f64> = (0..8 * 5).map(|k| f64::from(1 + k % 7)).collect();
        let map = DensityMap::new(8, 5, texels, interpolation).expect(VALID);
        warps.push(Box::new(map.clone().times_cosine().expect(VALID)));
        warps.push(Box::new(map));
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (index, warp) in warps.iter().enumerate() {
        for dir in axes.into_iter().chain(axes.map(|x| -x)) {
            let is_disk = warp.measure() == Measure::DiskArea;
            let dir = if is_disk { DVec3::new(dir.x, dir.y, 0.0) } else { dir };
            let error = match warp.inverse(dir) {
                Some(point) => 0.5 * warp.map(point).distance_squared(dir),
                None if warp.density(dir) > 0.0 => f64::INFINITY,
                None => 0.0,
            };
            errors.push(error, || format!("{dir} of map {index}"));
        }
    }
    errors
}
