use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

use glam::DVec3;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring, unit_direction};

use super::subjects::{Numbering, definition_of, exact};
use super::{bound_of_centre, bound_of_pixel, random_pixels};
use crate::{Errors, HardCase};

/// The largest resolution.
const NSIDE: f64 = Nside::MAX as f64;
/// The number of rings around a pole on whose edges directions are tested.
const RINGS: f64 = 1000.0;

const OUTSIDE: &str =
    "distance of a direction from the pixel returned for it, in units of the pixel's side";

const OF_PIXEL: &str = "face coordinates are sums of a longitude and a height up to 2, accurate to EPSILON, and the direction itself is accurate to EPSILON, both multiplied by nside";

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "directions_at_the_poles_at_the_largest_nside",
            what: OUTSIDE,
            bound: 4.0 * f64::EPSILON * RINGS,
            reason: "coordinates relative to the pole have a relative error of 4 EPSILON, for at most 1000 pixels",
            measure: || directions(&at_the_poles()),
        },
        HardCase {
            name: "directions_at_the_seams_at_the_largest_nside",
            what: OUTSIDE,
            bound: bound_of_pixel(NSIDE),
            reason: OF_PIXEL,
            measure: || directions(&[at_the_meridians(), at_the_slanted_seams()].concat()),
        },
        HardCase {
            name: "directions_at_the_borders_of_the_caps_at_the_largest_nside",
            what: OUTSIDE,
            bound: bound_of_pixel(NSIDE),
            reason: OF_PIXEL,
            measure: || directions(&at_the_borders()),
        },
        HardCase {
            name: "centres_at_the_largest_nside",
            what: "distance of a centre from its exact position, in units of the pixel's side; infinite if its pixel is not the original one",
            bound: bound_of_centre(NSIDE),
            reason: "three components, each accurate to EPSILON, of a vector whose pixel is 1/nside wide",
            measure: || in_both_orders(centres, centres),
        },
        HardCase {
            name: "numbers_of_both_orders_at_the_largest_nside",
            what: "0 if the number of a pixel equals that of the definition in integers and survives conversion to the other order and back, otherwise infinite",
            bound: 0.0,
            reason: "integers are exact",
            measure: numbers,
        },
    ]
}

/// Returns ring and nested order at the largest resolution.
fn orders() -> (Ring, Nested) {
    let nside = Nside::new(Nside::MAX).expect("the largest resolution");
    (Ring::new(nside), Nested::new(nside).expect("a power of 2"))
}

/// Returns the errors in ring and in nested order.
fn in_both_orders(ring: fn(Ring, &mut Errors), nested: fn(Nested, &mut Errors)) -> Errors {
    let mut errors = Errors::default();
    let (in_rings, in_faces) = orders();
    ring(in_rings, &mut errors);
    nested(in_faces, &mut errors);
    errors
}

/// Returns the distances of directions from their pixels, in both orders.
fn directions(list: &[DVec3]) -> Errors {
    fn outside<O: Numbering>(order: O, list: &[DVec3], errors: &mut Errors) {
        for &dir in list {
            let own = definition_of(order, order.pixel(dir));
            let error = own.map_or(f64::INFINITY, |own| own.excess(dir));
            errors.push(error, || format!("{}, direction {:?}", O::NAME, dir.to_array()));
        }
    }
    let mut errors = Errors::default();
    let (ring, nested) = orders();
    outside(ring, list, &mut errors);
    outside(nested, list, &mut errors);
    errors
}

/// Returns unit directions close to the given vectors.
fn unit(list: impl Iterator<Item = [f64; 3]>) -> Vec<DVec3> {
    list.map(|v| unit_direction(DVec3::from_array(v)).expect("no component is that small"))
        .collect()
}

/// Returns the direction at a height and a longitude. It is not normalized again, which would
/// change z.
fn at(z: f64, phi: f64) -> DVec3 {
    let sin = ((1.0 - z) * (1.0 + z)).sqrt();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), z)
}

/// Returns the number, its two neighbours, and their negatives.
fn around(x: f64) -> [f64; 6] {
    [x, x.next_up(), x.next_down(), -x, -x.next_up(), -x.next_down()]
}

/// Returns directions at both poles and close to them: at distances of 0, less than a pixel and
/// several pixels, and on the edges of pixels of some rings.
fn at_the_poles() -> Vec<DVec3> {
    let distances = [0.0, 5e-324, 1e-300, 1e-100, 1e-20, 1e-12, 1.0 / NSIDE, 2.5 / NSIDE, 1e-6];
    let sides = distances.into_iter().flat_map(around);
    let mut list = unit(sides.flat_map(|x| {
        let others = distances.into_iter().flat_map(around);
        others.flat_map(move |y| [[x, y, 1.0], [x, y, -1.0]])
    }));
    let (ring, _) = orders();
    // 2 ring (ring - 1) pixels are north of a ring; a prime step covers all longitudes.
    let near_the_pole = (0..2_u64 * 1000 * 999).step_by(997);
    for pixel in near_the_pole {
        for pixel in [pixel, ring.antipode(pixel)] {
            list.extend(super::on_edges(&ring, pixel));
        }
    }
    list
}

/// Returns longitudes at the edges and in the middle of faces, approached from both sides, from
/// pole to pole.
fn at_the_meridians() -> Vec<DVec3> {
    let heights = (-40..=40).map(|k| f64::from(k) / 40.0);
    unit(heights.flat_map(|z| {
        let sin = ((1.0 - z) * (1.0 + z)).sqrt();
        let on_axes = [0.0, 5e-324, 1e-300, f64::EPSILON, 1e-12].into_iter().flat_map(around);
        let near_axes =
            on_axes.flat_map(move |w| [[sin, w, z], [-sin, w, z], [w, sin, z], [w, -sin, z]]);
        // In the middle of a face x and y are equal.
        let x = sin * FRAC_1_SQRT_2;
        let diagonal = around(x).into_iter().flat_map(move |y| [[x, y, z], [-x, y, z]]);
        near_axes.chain(diagonal)
    }))
}

/// Returns directions on the seams between equatorial and polar faces, approached from north and
/// south: `|z| = (2/3)(1 - |t|)` at longitude `(q + t/2) pi/2`.
fn at_the_slanted_seams() -> Vec<DVec3> {
    let places = (0..4_i32).flat_map(|q| (-40..=40_i32).map(move |k| (q, f64::from(k) / 40.0)));
    let near = |(q, t): (i32, f64)| {
        let phi = (f64::from(q) + 0.5 * t) * FRAC_PI_2;
        around((1.0 - t.abs()) * 2.0 / 3.0).map(|z| at(z, phi))
    };
    places.flat_map(near).collect()
}

/// Returns directions on the border between belt and caps at many longitudes, approached from both
/// sides.
fn at_the_borders() -> Vec<DVec3> {
    const LONGITUDES: u32 = 400;
    let longitudes = (0..LONGITUDES).map(|k| TAU * f64::from(k) / f64::from(LONGITUDES));
    let mut list = Vec::new();
    for phi in longitudes {
        list.extend(around(2.0 / 3.0).map(|z| at(z, phi)));
    }
    list
}

/// Returns pixels at the ends of the numbering, of caps, rings and faces, and random ones.
fn pixels(nside: Nside) -> Vec<u64> {
    let n = u64::from(nside.value());
    let (cap, all, face) = (2 * n * (n - 1), nside.n_pixels(), n * n);
    let faces = (0..=12).map(|k| k * face);
    let starts =
        [0, 4, 12, cap - 4 * n, cap, cap + 4 * n, all / 2, all - cap, all - cap - 4 * n, all];
    let near = |start: u64| (start.saturating_sub(20)..(start + 20).min(all)).step_by(3);
    let mut list: Vec<u64> = starts.into_iter().chain(faces).flat_map(near).collect();
    list.extend(random_pixels(nside, 1000));
    list
}

fn centres<O: Numbering>(order: O, errors: &mut Errors) {
    for pixel in pixels(order.nside()) {
        let centre = order.centre(pixel);
        let own = definition_of(order, pixel);
        let distance = own.map_or(f64::INFINITY, |own| own.distance_from_centre(centre));
        let found = exact(order.pixel(centre) == pixel);
        errors.push(distance + found, || format!("{}, pixel {pixel}", O::NAME));
    }
}

fn numbers() -> Errors {
    fn of_ring(ring: Ring, errors: &mut Errors) {
        let nested = Nested::new(ring.nside());
        for pixel in pixels(ring.nside()) {
            let back = nested.as_ref().map(|nested| nested.to_ring(nested.from_ring(pixel)));
            let right = back == Ok(pixel) && definition_of(ring, pixel).is_some();
            errors.push(exact(right), || format!("ring, pixel {pixel}"));
        }
    }
    fn of_nested(nested: Nested, errors: &mut Errors) {
        for pixel in pixels(nested.nside()) {
            let ring = nested.to_ring(pixel);
            let own = definition_of(nested, pixel).map(|own| own.ring_number());
            let right = own == Some(ring.into()) && nested.from_ring(ring) == pixel;
            errors.push(exact(right), || format!("nested, pixel {pixel}"));
        }
    }
    in_both_orders(of_ring, of_nested)
}
