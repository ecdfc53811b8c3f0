use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_warps::{DensityMap, Error, Interpolation, Support, Warp};

use crate::subjects::{points, texels};

const BOTH: [Interpolation; 2] = [Interpolation::Constant, Interpolation::Bilinear];

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
fn index(x: f64) -> usize {
    x as usize
}

/// The map at a colatitude and longitude, by its definition.
fn definition(
    map: &[f64],
    width: usize,
    interpolation: Interpolation,
    theta: f64,
    phi: f64,
) -> f64 {
    let height = map.len() / width;
    let (row, column) = (theta / PI * height as f64, phi / TAU * width as f64);
    let texel = |i: f64, j: f64| {
        let (i, j) = (i.clamp(0.0, height as f64 - 1.0), j.rem_euclid(width as f64));
        map[index(i) * width + index(j)]
    };
    match interpolation {
        Interpolation::Constant => texel(row.floor(), column.floor()),
        Interpolation::Bilinear => {
            let (row, column) = (row - 0.5, column - 0.5);
            let (i, j) = (row.floor(), column.floor());
            let (s, t) = (row - i, column - j);
            (1.0 - s) * ((1.0 - t) * texel(i, j) + t * texel(i, j + 1.0))
                + s * ((1.0 - t) * texel(i + 1.0, j) + t * texel(i + 1.0, j + 1.0))
        }
    }
}

/// Densities over the definition have the same ratio everywhere, that of the integral.
#[test]
fn densities_are_proportional_to_the_definition() {
    for interpolation in BOTH {
        for (width, height) in [(40, 20), (1, 6), (7, 1), (17, 5)] {
            let map = texels(width, height);
            let warp = DensityMap::new(width, height, map.clone(), interpolation).unwrap();
            let cosine = warp.clone().times_cosine().unwrap();
            let ratios = |warp: &DensityMap, has_cosine: bool| {
                let mut range = [f64::INFINITY, 0.0];
                for point in points(500) {
                    let sample = warp.sample(point);
                    let dir = sample.point;
                    let theta = dir.x.hypot(dir.y).atan2(dir.z);
                    let phi = dir.y.atan2(dir.x).rem_euclid(TAU);
                    let weight = if has_cosine { dir.z } else { 1.0 };
                    let ratio = sample.density
                        / (definition(&map, width, interpolation, theta, phi) * weight);
                    range = [range[0].min(ratio), range[1].max(ratio)];
                }
                range[1] / range[0] - 1.0
            };
            // The steepest slope of the map and cos(theta) near the horizon magnify roundings.
            let (sphere, hemisphere) = (ratios(&warp, false), ratios(&cosine, true));
            assert!(sphere < 1e-12, "{width} x {height} {interpolation:?}: {sphere:e}");
            assert!(hemisphere < 1e-12, "{width} x {height} {interpolation:?}: {hemisphere:e}");
        }
    }
}

/// Above the equator the restriction is the map, rescaled; the order of floor and restriction does
/// not matter.
#[test]
fn the_restriction_to_the_hemisphere_is_the_map_rescaled() {
    for interpolation in BOTH {
        for (width, height) in [(40, 20), (1, 6), (7, 1), (17, 5)] {
            let mut map = texels(width, height);
            map[width * height.div_ceil(2)..].fill(1e-3);
            let warp = DensityMap::new(width, height, map, interpolation).unwrap();
            let upper = warp.clone().on_hemisphere().unwrap();
            assert_eq!(upper.support(), Support::UpperHemisphere);
            // u is the distribution function of theta.
            let [visible, _] = warp.inverse(DVec3::X).unwrap();
            let name = format!("{width} x {height} {interpolation:?}");
            let mut min = f64::INFINITY;
            for point in points(2000) {
                let dir = upper.map(point);
                assert!(dir.z >= 0.0, "{name}: {dir}");
                assert_eq!((upper.density(-dir), upper.inverse(-dir)), (0.0, None));
                let share = warp.density(dir) / upper.density(dir);
                assert!((share / visible - 1.0).abs() < 1e-12, "{name}: {share}, not {visible}");
                min = min.min(upper.density(dir));
            }
            let ratio = min / upper.min_density();
            assert!((1.0 - 1e-13..2.0).contains(&ratio), "{name}: {ratio}");
            let first = upper.with_floor(0.2).unwrap();
            let last = warp.with_floor(0.2).unwrap().on_hemisphere().unwrap();
            for point in points(50) {
                assert_eq!(first.sample(point), last.sample(point), "{name}");
            }
            assert_eq!(first.min_density().to_bits(), last.min_density().to_bits(), "{name}");
        }
    }
}

/// The search over blocks agrees with sums over all columns of piecewise constant maps.
#[test]
fn the_search_agrees_with_linear_search() {
    let (width, height) = (100, 6);
    let map = texels(width, height);
    let warp = DensityMap::new(width, height, map.clone(), Interpolation::Constant).unwrap();
    let row_mass = |i: usize| {
        let angle = |i: usize| (PI * i as f64 / height as f64).cos();
        (angle(i) - angle(i + 1)) * map[i * width..(i + 1) * width].iter().sum::<f64>()
    };
    let total: f64 = (0..height).map(row_mass).sum();
    for [u, v] in points(2000) {
        let (mut row, mut rest) = (0, u * total);
        while rest > row_mass(row) {
            rest -= row_mass(row);
            row += 1;
        }
        let texels = &map[row * width..(row + 1) * width];
        let (mut column, mut place) = (0, v * texels.iter().sum::<f64>());
        while place > texels[column] {
            place -= texels[column];
            column += 1;
        }
        let top = (PI * row as f64 / height as f64).cos();
        let z = top - rest / texels.iter().sum::<f64>();
        let phi = TAU * (column as f64 + place / texels[column]) / width as f64;
        let dir = warp.map([u, v]);
        assert!((dir.z - z).abs() < 1e-13, "{u}, {v}: {dir}, not z = {z}");
        assert!(
            (dir.y.atan2(dir.x).rem_euclid(TAU) - phi).abs() < 1e-12,
            "{u}, {v}: {dir}, not {phi}"
        );
    }
}

#[test]
fn the_floor_is_a_mixture_with_the_uniform_density() {
    for interpolation in BOTH {
        let map = DensityMap::new(40, 20, texels(40, 20), interpolation).unwrap();
        let upper = map.clone().on_hemisphere().unwrap();
        let cosine = map.clone().times_cosine().unwrap();
        for (warp, solid_angle) in [(map, 2.0 * TAU), (upper, TAU), (cosine, TAU)] {
            let mixed = warp.clone().with_floor(0.25).unwrap();
            assert!(mixed.min_density() >= 0.25 / solid_angle * (1.0 - 1e-14));
            for point in points(200) {
                let dir = warp.map(point);
                let expected = 0.75 * warp.density(dir) + 0.25 / solid_angle;
                assert!((mixed.density(dir) / expected - 1.0).abs() < 1e-13, "{point:?}");
            }
        }
    }
}

#[test]
fn a_texel_of_1e20_takes_all_samples_and_the_floor_some() {
    for interpolation in BOTH {
        let mut map = vec![1.0; 64 * 32];
        map[10 * 64 + 20] = 1e20;
        let warp = DensityMap::new(64, 32, map, interpolation).unwrap();
        let centre = {
            let (theta, phi): (f64, f64) = (PI * 10.5 / 32.0, TAU * 20.5 / 64.0);
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        for point in points(500) {
            let sample = warp.sample(point);
            assert!(sample.point.distance(centre) < 0.2, "{interpolation:?}: {sample:?}");
            let [u, v] = warp.inverse(sample.point).unwrap();
            assert!(
                (u - point[0]).abs().max((v - point[1]).abs()) < 1e-13,
                "{interpolation:?}: {point:?}"
            );
        }
        let mixed = warp.with_floor(0.5).unwrap();
        let far = points(500).filter(|point| mixed.map(*point).distance(centre) > 0.2).count();
        assert!((235..250).contains(&far), "{far} of 500 samples are uniform");
        for [u, v] in points(500) {
            let [got_u, got_v] = mixed.inverse(mixed.map([u, v])).unwrap();
            assert!(
                (got_u - u).abs().max((got_v - v).abs()) < 1e-12,
                "{interpolation:?}: {u}, {v}"
            );
        }
    }
}

#[test]
fn zeros_are_never_sampled_and_have_no_inverse() {
    let mut map = texels(32, 16);
    map[..4 * 32].fill(0.0);
    map[7 * 32..9 * 32].fill(0.0);
    for row in map.chunks_exact_mut(32) {
        row[..20].fill(0.0);
    }
    for interpolation in BOTH {
        let warp = DensityMap::new(32, 16, map.clone(), interpolation).unwrap();
        assert_eq!(warp.support(), Support::Directions);
        for point in points(2000) {
            let sample = warp.sample(point);
            assert!(sample.density > 0.0, "{point:?}: {sample:?}");
            assert!(warp.inverse(sample.point).is_some(), "{point:?}: {sample:?}");
        }
        assert_eq!((warp.density(DVec3::Z), warp.inverse(DVec3::Z)), (0.0, None));
        let mixed = warp.with_floor(0.1).unwrap();
        assert_eq!(mixed.support(), Support::Sphere);
        assert!(mixed.inverse(DVec3::Z).is_some());
    }
}

#[test]
fn supports_and_minima_are_exact() {
    for interpolation in BOTH {
        let map = |texels: Vec<f64>| DensityMap::new(4, 2, texels, interpolation).unwrap();
        let ones = map(vec![1.0; 8]);
        assert_eq!(ones.support(), Support::Sphere);
        assert!((ones.min_density() * 2.0 * TAU - 1.0).abs() < 1e-15);
        let cosine = ones.times_cosine().unwrap();
        assert_eq!((cosine.support(), cosine.min_density()), (Support::UpperHemisphere, 0.0));
        let lower = map([[1.0; 4], [0.0; 4]].concat());
        assert_eq!(lower.clone().support(), Support::Directions);
        assert_eq!(lower.times_cosine().unwrap().support(), Support::UpperHemisphere);
    }
}

/// The coordinate 1 is rounded to 1 - 2^-53, which is 2e-8 radians from the south pole.
#[test]
fn the_poles_are_inverted() {
    for interpolation in BOTH {
        let warp = DensityMap::new(8, 5, texels(8, 5), interpolation).unwrap();
        for pole in [DVec3::Z, DVec3::NEG_Z] {
            let image = warp.map(warp.inverse(pole).unwrap());
            assert!(image.distance(pole) < 1e-7, "{interpolation:?}: {pole} became {image}");
        }
    }
}

/// A map of one colour is the uniform sphere, whatever its unit.
#[test]
fn texels_of_every_magnitude_are_scaled() {
    for value in [5e-324, 1e-300, 1e300, f64::MAX] {
        for interpolation in BOTH {
            let warp = DensityMap::new(64, 32, vec![value; 64 * 32], interpolation).unwrap();
            for [u, v] in points(50) {
                let sample = warp.sample([u, v]);
                assert!((sample.density * 2.0 * TAU - 1.0).abs() < 1e-14, "{value:e}: {sample:?}");
                assert!((sample.point.z - (1.0 - 2.0 * u)).abs() < 1e-14, "{value:e}: {sample:?}");
            }
        }
    }
}

#[test]
fn invalid_maps_are_errors_that_name_the_texel() {
    let with = |value: f64| {
        let mut map = vec![1.0; 12];
        map[7] = value;
        DensityMap::new(4, 3, map, Interpolation::Bilinear)
    };
    for value in [-1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = with(value).unwrap_err();
        assert!(matches!(error, Error::Texel { row: 1, column: 3, .. }), "{error}");
        assert!(error.to_string().contains("(row 1, column 3; 0-based)"), "{error}");
    }
    let new =
        |width, height, texels| DensityMap::new(width, height, texels, Interpolation::Constant);
    assert_eq!(new(0, 3, vec![]).unwrap_err(), Error::Shape { width: 0, height: 3 });
    assert_eq!(
        new(2, 2, vec![1.0; 5]).unwrap_err(),
        Error::TexelCount { width: 2, height: 2, got: 5 }
    );
    assert_eq!(new(2, 2, vec![0.0; 4]).unwrap_err(), Error::NoDensity { domain: "the sphere" });
    let lower = new(1, 2, vec![0.0, 1.0]).unwrap();
    let expected = Error::NoDensity { domain: "the hemisphere z >= 0" };
    assert_eq!(lower.clone().on_hemisphere().unwrap_err(), expected);
    assert_eq!(lower.times_cosine().unwrap_err(), expected);
    for floor in [-0.1, 1.0, f64::NAN] {
        assert!(new(1, 1, vec![1.0]).unwrap().with_floor(floor).is_err());
    }
}

/// Memory: 1.2 GB, of which the texels are 1.07 GB.
#[test]
#[ignore = "slow"]
fn a_map_of_16384_x_8192_texels_is_sampled() {
    let (width, height) = (16384, 8192);
    let mut map = vec![1.0; width * height];
    map[5000 * width + 1000] = 1e6;
    let warp = DensityMap::new(width, height, map, Interpolation::Bilinear).unwrap();
    for point in points(10_000) {
        let [u, v] = warp.inverse(warp.map(point)).unwrap();
        // A texel has 1e-8 of the sphere, and rounding of the direction is magnified by the sun.
        assert!((u - point[0]).abs().max((v - point[1]).abs()) < 1e-11, "{point:?}");
    }
}
