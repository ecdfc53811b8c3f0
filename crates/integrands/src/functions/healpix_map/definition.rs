//! The coefficients by their definition: every pixel's Fourier integral at many heights.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use num_complex::Complex;
use sphvar_healpix::{Nested, Nside};
use sphvar_sh::{Alm, Colatitude, Domain, GaussLegendre};
use sphvar_sht::{RingTransform, RingWorkspace};

use super::HealpixMap;
use crate::Error;

/// The intervals of longitude of the pixels at a height, by middle, half of the width, and value.
struct Circle {
    colatitude: Colatitude,
    weight: f64,
    intervals: Vec<[f64; 3]>,
}

fn definition(map: &HealpixMap, domain: Domain, lmax: usize) -> Alm {
    let circles = circles(map, domain, lmax);
    let mut alm = Alm::zeros(lmax).unwrap();
    RingTransform::new(lmax).unwrap().adjoint_into(
        circles.iter().map(|circle| circle.colatitude),
        |m, fourier| {
            let order = m as f64;
            for (f, circle) in fourier.iter_mut().zip(&circles) {
                let integral = |&[middle, half, value]: &[f64; 3]| {
                    let width = if m == 0 { half } else { (order * half).sin() / order };
                    Complex::cis(-order * middle) * (2.0 * width * value)
                };
                *f = circle.intervals.iter().map(integral).sum::<Complex<f64>>() * circle.weight;
            }
        },
        &mut RingWorkspace::default(),
        &mut alm,
    );
    alm
}

fn circles(map: &HealpixMap, domain: Domain, lmax: usize) -> Vec<Circle> {
    let n = map.n();
    let side = n as f64;
    let end = if domain == Domain::Sphere { 4 * n } else { 2 * n };
    let rule = GaussLegendre::new(30 + lmax / n).unwrap();
    let mut circles = Vec::new();
    // Between the centres of rings i and i + 1; ring 0 is the pole.
    for i in 0..end {
        let from_pole = i.min(4 * n - 1 - i);
        for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
            let share = 0.5 * (1.0 + x);
            let mut intervals = Vec::new();
            let (sin, z, slope);
            if from_pole < n {
                let s = from_pole as f64 + share;
                let half_sin = s / (side * 6f64.sqrt());
                sin = 2.0 * half_sin * (1.0 - half_sin * half_sin).sqrt();
                z = (1.0 - 2.0 * half_sin * half_sin) * if i < 2 * n { 1.0 } else { -1.0 };
                slope = 2.0 * s / (3.0 * side * side);
                for (ring, from, to) in [(from_pole, share, 1.0), (from_pole + 1, 0.0, share)] {
                    if ring == 0 {
                        continue;
                    }
                    let values = map.ring(if i < 2 * n { ring - 1 } else { 4 * n - 1 - ring });
                    for (k, &value) in values.iter().enumerate() {
                        let turns = (k / ring) as f64 * FRAC_PI_2;
                        let middle = (k % ring) as f64 + 0.5 * (from + to);
                        let step = FRAC_PI_2 / s;
                        intervals.push([turns + middle * step, 0.5 * (to - from) * step, value]);
                    }
                }
            } else {
                slope = 2.0 / (3.0 * side);
                z = (2.0 * side - (i as f64 + share)) * slope;
                sin = ((1.0 - z) * (1.0 + z)).sqrt();
                for (ring, width) in [(i, 1.0 - share), (i + 1, share)] {
                    let step = FRAC_PI_2 / side;
                    let first = if (ring - n).is_multiple_of(2) { 0.5 } else { 0.0 };
                    for (k, &value) in map.ring(ring - 1).iter().enumerate() {
                        intervals.push([(k as f64 + first) * step, 0.5 * width * step, value]);
                    }
                }
            }
            circles.push(Circle {
                colatitude: Colatitude::from_direction(DVec3::new(sin, 0.0, z)),
                weight: 0.5 * w * slope,
                intervals,
            });
        }
    }
    circles
}

/// Returns the largest difference of coefficients relative to the norm of the map.
fn difference(map: &HealpixMap, domain: Domain, lmax: usize) -> f64 {
    let largest = map.values.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let squares = map.values.iter().map(|v| (v / largest).powi(2)).sum::<f64>();
    let norm = largest * (squares * map.nside.pixel_area()).sqrt();
    let (fast, slow) = (map.alm(domain, lmax).unwrap(), definition(map, domain, lmax));
    let differences = fast.values().iter().zip(slow.values()).map(|(a, b)| (a - b).norm() / norm);
    differences.fold(0.0, f64::max)
}

/// Values of all signs without symmetry.
fn noise(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 * 2f64.powi(-52) - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn map(nside: u32, values: impl FnOnce(usize) -> Vec<f64>) -> HealpixMap {
    let nside = Nside::new(nside).unwrap();
    HealpixMap::new(nside, values(usize::try_from(nside.n_pixels()).unwrap())).unwrap()
}

const TOLERANCE: f64 = 1e-14;

fn check(map: &HealpixMap, lmax: usize, name: &str) {
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let difference = difference(map, domain, lmax);
        assert!(
            difference <= TOLERANCE,
            "{name}, nside {}, lmax {lmax}, {domain:?}: {difference:e}",
            map.n()
        );
    }
}

#[test]
fn coefficients_are_those_of_the_definition() {
    // Degrees far below and far above nside, blocks of orders that end anywhere, and orders beyond
    // the number of pixels of a ring.
    for (nside, lmax) in
        [(1, 0), (1, 1), (1, 130), (2, 7), (2, 61), (3, 8), (4, 40), (5, 9), (8, 32), (11, 3)]
    {
        check(&map(nside, noise), lmax, "noise");
        check(&map(nside, |count| vec![1.0; count]), lmax, "constant");
    }
}

#[test]
fn coefficients_of_single_pixels_are_those_of_the_definition() {
    // At the pole, across the seam, before, on, and after the border of the cap, on the equator,
    // and the last one.
    for pixel in [0, 3, 11, 23, 24, 25, 39, 40, 71, 88, 103, 151, 168, 191] {
        for value in [1.0, -1e150, 1e-150] {
            let values = |count| (0..count).map(|i| if i == pixel { value } else { 0.0 }).collect();
            check(&map(4, values), 21, "one pixel");
        }
    }
    let values = |count| (0..count).map(|i| if i % 2 == 0 { 1e150 } else { -1e-150 }).collect();
    check(&map(3, values), 20, "magnitudes");
    let too_large = HealpixMap::new(Nside::new(1).unwrap(), vec![1e300; 12]);
    assert!(matches!(too_large, Err(Error::Magnitude { .. })));
}

#[test]
fn pixels_divided_into_four_have_the_same_coefficients() {
    for (nside, lmax) in [(1, 50), (8, 70), (32, 20), (64, 100)] {
        let order = |nside| Nested::new(Nside::new(nside).unwrap()).unwrap();
        let values = noise(12 * (nside * nside) as usize);
        let divided = values.iter().flat_map(|&v| [v; 4]).collect();
        let coarse = HealpixMap::from_nested(order(nside), values).unwrap();
        let fine = HealpixMap::from_nested(order(2 * nside), divided).unwrap();
        let size = 1.0 / (4.0 * PI / 3.0).sqrt();
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let [coarse, fine] = [&coarse, &fine].map(|map| map.alm(domain, lmax).unwrap());
            for (a, b) in coarse.values().iter().zip(fine.values()) {
                assert!((a - b).norm() * size < TOLERANCE, "nside {nside}, {domain:?}: {a}, {b}");
            }
        }
    }
}

#[test]
fn coefficients_do_not_depend_on_the_number_of_threads() {
    let map = map(16, noise);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| map.alm(Domain::Sphere, 60).unwrap())
    };
    assert_eq!(with(1), with(3));
}
