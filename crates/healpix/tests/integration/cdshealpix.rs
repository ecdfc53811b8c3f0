//! Comparison with the independent crate `cdshealpix`. It takes longitude and latitude, and its
//! ring order supports any nside.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cdshealpix::compass_point::MainWind;
use cdshealpix::{nested as cds_nested, ring as cds_ring};
use glam::DVec3;
use proptest::prelude::*;
use sphvar_healpix::{Cell, Nested, Nside, PixelOrder, Ring};

const CASES: u32 = 4000;

fn vector(lon: f64, lat: f64) -> DVec3 {
    let (sin_lat, cos_lat) = lat.sin_cos();
    let (sin_lon, cos_lon) = lon.sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Points on the whole sphere, and with equal frequency close to the poles, the border of the caps
/// and the seams between faces.
fn lon_lat() -> impl Strategy<Value = (f64, f64)> {
    let border = (2.0_f64 / 3.0).asin();
    let lat = prop_oneof![
        (-1.0..1.0_f64).prop_map(f64::asin),
        (0.0..15.0_f64, any::<bool>()).prop_map(|(digits, south)| {
            let lat = FRAC_PI_2 - 10.0_f64.powf(-digits);
            if south { -lat } else { lat }
        }),
        (0.0..15.0_f64, any::<bool>(), any::<bool>()).prop_map(move |(digits, south, below)| {
            let offset = 0.1 * 10.0_f64.powf(-digits);
            let lat = border + if below { -offset } else { offset };
            if south { -lat } else { lat }
        }),
    ];
    let lon = prop_oneof![
        0.0..TAU,
        (0..4_u32, 0.0..15.0_f64).prop_map(|(quarter, digits)| {
            f64::from(quarter) * FRAC_PI_2 + 10.0_f64.powf(-digits)
        }),
        (1..=4_u32, 0.0..15.0_f64).prop_map(|(quarter, digits)| {
            f64::from(quarter) * FRAC_PI_2 - 10.0_f64.powf(-digits)
        }),
    ];
    (lon, lat)
}

fn any_nside() -> impl Strategy<Value = u32> {
    prop_oneof![1..=40_u32, 1..=Nside::MAX, Just(Nside::MAX)]
}

/// Returns the effect of rounded angles in pixels: angles (up to 2 pi) are rounded to 2 eps, each
/// library adds the same, and a radian has up to 1.3 nside pixels.
fn slack(nside: u32) -> f64 {
    8.0 * f64::EPSILON * f64::from(nside)
}

/// Returns whether `(u, v)` is so close to an edge that the two libraries may differ.
fn on_edge(u: f64, v: f64, nside: u32) -> bool {
    let slack = slack(nside);
    [u, v, 1.0 - u, 1.0 - v].iter().any(|&d| d <= slack)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn pixel_of_a_direction((lon, lat) in lon_lat(), n in any_nside(), depth in 0..=29_u8) {
        let ring = Ring::new(Nside::new(n).unwrap());
        let (pixel, u, v) = ring.invert_uniform_point(vector(lon, lat));
        if !on_edge(u, v, n) {
            prop_assert_eq!(pixel, cds_ring::hash(n, lon, lat), "nside {}, u {}, v {}", n, u, v);
        }
        let n = 1 << depth;
        let nested = Nested::new(Nside::new(n).unwrap()).unwrap();
        let (pixel, u, v) = nested.invert_uniform_point(vector(lon, lat));
        if !on_edge(u, v, n) {
            prop_assert_eq!(pixel, cds_nested::hash(depth, lon, lat), "u {}, v {}", u, v);
        }
    }

    #[test]
    fn coordinates_in_the_cell((lon, lat) in lon_lat(), depth in 0..=29_u8) {
        let n = 1 << depth;
        let (_, u, v) = Cell::invert_uniform_point(Nside::new(n).unwrap(), vector(lon, lat));
        let (_, dx, dy) = cds_nested::hash_with_dxdy(depth, lon, lat);
        if !on_edge(u, v, n) {
            prop_assert!((u - dx).abs() <= slack(n) && (v - dy).abs() <= slack(n),
                "({}, {}) against ({}, {})", u, v, dx, dy);
        }
    }

    #[test]
    fn centre_and_corners(fraction in 0.0..1.0_f64, n in any_nside(), depth in 0..=29_u8) {
        // Angles of up to 2 pi are rounded on both sides.
        let tolerance = 8.0 * f64::EPSILON;
        let ring = Ring::new(Nside::new(n).unwrap());
        let pixel = fraction_of(fraction, ring.n_pixels());
        let (lon, lat) = cds_ring::center(n, pixel);
        prop_assert!(ring.centre(pixel).distance(vector(lon, lat)) <= tolerance, "pixel {}", pixel);

        let nested = Nested::new(Nside::new(1 << depth).unwrap()).unwrap();
        let pixel = fraction_of(fraction, nested.n_pixels());
        let (lon, lat) = cds_nested::center(depth, pixel);
        prop_assert!(nested.centre(pixel).distance(vector(lon, lat)) <= tolerance, "pixel {}", pixel);
        let [north, west, south, east] = nested.corners(pixel);
        for (ours, (lon, lat)) in [south, east, north, west].iter().zip(cds_nested::vertices(depth, pixel)) {
            prop_assert!(ours.distance(vector(lon, lat)) <= tolerance, "pixel {}: {} against {:?}", pixel, ours, (lon, lat));
        }
    }

    #[test]
    fn conversion_and_neighbours(fraction in 0.0..1.0_f64, depth in 0..=29_u8) {
        let nested = Nested::new(Nside::new(1 << depth).unwrap()).unwrap();
        let pixel = fraction_of(fraction, nested.n_pixels());
        let layer = cds_nested::get(depth);
        prop_assert_eq!(nested.to_ring(pixel), layer.to_ring(pixel));
        prop_assert_eq!(nested.from_ring(pixel), layer.from_ring(pixel));
        check_neighbours(&nested, depth, pixel);
    }
}

fn fraction_of(fraction: f64, n_pixels: u64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "any pixel is valid"
    )]
    let pixel = (fraction * n_pixels as f64) as u64;
    pixel.min(n_pixels - 1)
}

fn check_neighbours(nested: &Nested, depth: u8, pixel: u64) {
    use MainWind::{E, N, NE, NW, S, SE, SW, W};
    let theirs = cds_nested::neighbours(depth, pixel, false);
    let expected = [SW, W, NW, N, NE, E, SE, S].map(|wind| theirs.get(wind).copied());
    assert_eq!(nested.neighbours(pixel), expected, "depth {depth}, pixel {pixel}");
}

#[test]
fn every_neighbour_on_small_grids() {
    for depth in 0..=4 {
        let nested = Nested::new(Nside::new(1 << depth).unwrap()).unwrap();
        for pixel in 0..nested.n_pixels() {
            check_neighbours(&nested, depth, pixel);
        }
    }
}

#[test]
fn poles() {
    for depth in [0, 1, 10, 29] {
        let nested = Nested::new(Nside::new(1 << depth).unwrap()).unwrap();
        // In the middle of each quadrant, where the longitude is unambiguous.
        for quarter in 0..4 {
            let lon = PI / 4.0 + f64::from(quarter) * FRAC_PI_2;
            for lat in [FRAC_PI_2 - 1e-12, 1e-12 - FRAC_PI_2] {
                assert_eq!(
                    nested.pixel(vector(lon, lat)),
                    cds_nested::hash(depth, lon, lat),
                    "depth {depth}, lon {lon}, lat {lat}"
                );
            }
        }
    }
}
