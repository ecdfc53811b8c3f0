//! Conversion of directions to HEALPix pixels and back.
//!
//! A result is correct if the returned pixel contains the direction, tested in twice the working
//! precision by the definition of the projection. The error is the distance of the direction from
//! the pixel, in units of the pixel's side. The rounding of the direction itself, EPSILON, is
//! `EPSILON nside` in these units.

mod definition;
mod extremes;
mod subjects;

use std::f64::consts::TAU;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};

use crate::{Area, Effort, Subject, Trial};

pub(crate) use extremes::hard_cases;

/// The seed of the directions and pixels.
const SEED: u64 = 1;

/// Returns the trials of this area.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let (resolutions, count): (&[u32], usize) = match effort {
        Effort::Quick => (&[1, 64, 1 << 20, 1 << 29], 4000),
        Effort::Full => (&[1, 18, 64, 1024, 1 << 15, 1 << 20, 1 << 25, 1 << 29], 100_000),
    };
    let resolutions = resolutions.iter().map(|&n| Nside::new(n).expect("in range"));
    resolutions.flat_map(|nside| at_resolution(nside, count)).collect()
}

/// Returns the trials at one resolution, in ring order and, where it exists, in nested order.
fn at_resolution(nside: Nside, count: usize) -> Vec<Trial> {
    let ring = Ring::new(nside);
    let (case, side) = (format!("nside = {nside}"), f64::from(nside.value()));
    let mut trials = Vec::new();
    let mut add = |method: &str, unit, bound, reference, subject: Box<dyn Subject>| {
        trials.push(Trial {
            area: Area::Indexing,
            method: method.to_owned(),
            case: case.clone(),
            count: count as f64,
            unit,
            relative_to: "the side of a pixel",
            bound,
            reference,
            subject,
        });
    };
    let plane = "definition, twice the precision";
    let (integers, itself) = ("definition, integers", "the pixel whose centre it is");
    let (to_pixel, to_centre) = (bound_of_pixel(side), bound_of_centre(side));
    let pixels = random_pixels(nside, count);
    // Half of them are random and half lie where rounding decides.
    let mut directions = random_directions(count);
    for (i, (dir, &pixel)) in directions.iter_mut().zip(&pixels).enumerate().step_by(2) {
        *dir = on_edges(&ring, pixel)[i / 2 % 4];
    }

    add("ring, pixel", "directions", to_pixel, plane, subjects::pixel(ring, directions.clone()));
    add("ring, batch", "directions", to_pixel, plane, subjects::pixels(ring, directions.clone()));
    add("ring, centre", "pixels", to_centre, plane, subjects::centre(ring, pixels.clone()));
    add(
        "ring, centre to pixel",
        "directions",
        0.0,
        itself,
        subjects::return_trip(ring, pixels.clone()),
    );
    if let Ok(nested) = Nested::new(nside) {
        add(
            "nested, pixel",
            "directions",
            to_pixel,
            plane,
            subjects::pixel(nested, directions.clone()),
        );
        add("nested, batch", "directions", to_pixel, plane, subjects::pixels(nested, directions));
        add("nested, centre", "pixels", to_centre, plane, subjects::centre(nested, pixels.clone()));
        add(
            "nested, centre to pixel",
            "directions",
            0.0,
            itself,
            subjects::return_trip(nested, pixels.clone()),
        );
        add("nested to ring", "pixels", 0.0, integers, subjects::renumbering(nested, pixels));
    }
    trials
}

/// Returns the bound on the distance of a direction from its pixel, in units of the pixel's side:
/// the coordinates in a face, sums of a longitude and a height up to 2, are accurate to EPSILON,
/// and so is the direction.
fn bound_of_pixel(nside: f64) -> f64 {
    2.0 * f64::EPSILON * nside
}

/// Returns the bound on the error of a centre's position, in units of the pixel's side: three
/// components, each accurate to EPSILON.
fn bound_of_centre(nside: f64) -> f64 {
    2.0 * f64::EPSILON * nside
}

fn random_directions(count: usize) -> Vec<DVec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut direction = || {
        let (z, phi) = (2.0 * rng.random::<f64>() - 1.0, TAU * rng.random::<f64>());
        let sin = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), z)
    };
    (0..count).map(|_| direction()).collect()
}

/// Returns a direction on each edge of a pixel, SW, SE, NE and NW.
fn on_edges(order: &dyn PixelOrder, pixel: u64) -> [DVec3; 4] {
    [(0.0, 0.3), (0.6, 0.0), (1.0, 0.8), (0.1, 1.0)].map(|(u, v)| order.uniform_point(pixel, u, v))
}

fn random_pixels(nside: Nside, count: usize) -> Vec<u64> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    (0..count).map(|_| rng.random_range(0..nside.n_pixels())).collect()
}
