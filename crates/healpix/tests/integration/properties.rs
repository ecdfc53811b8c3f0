//! Properties of the maps, with generators that emphasize the poles, the seams between faces and
//! the border of the caps.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use proptest::prelude::*;
use sphvar_healpix::{Cell, Error, Nested, Nside, PixelOrder, Ring, unit_direction};

const CASES: u32 = 4000;

/// Rounding of the components of a unit vector: two or three products round by half an eps each.
const DIRECTION_TOLERANCE: f64 = 4.0 * f64::EPSILON;

fn any_nside() -> impl Strategy<Value = Nside> {
    prop_oneof![
        1..=8_u32,
        1..=1000_u32,
        (0..=29_u32).prop_map(|k| 1 << k),
        1..=Nside::MAX,
        Just(Nside::MAX),
    ]
    .prop_map(|n| Nside::new(n).unwrap())
}

/// A coordinate in a face: arbitrary, or within three of an end.
fn coordinate(n: u32) -> impl Strategy<Value = u32> {
    prop_oneof![
        0..n,
        (0..3_u32).prop_map(move |k| k.min(n - 1)),
        (0..3_u32).prop_map(move |k| n - 1 - k.min(n - 1)),
    ]
}

/// A cell: arbitrary, at a seam, or in the rings nside - 1, nside and nside + 1 from a pole.
fn any_cell() -> impl Strategy<Value = Cell> {
    cell_of(any_nside())
}

fn cell_of(nside: impl Strategy<Value = Nside>) -> impl Strategy<Value = Cell> {
    nside.prop_flat_map(|nside| {
        let n = nside.value();
        let anywhere = (0..12_u8, coordinate(n), coordinate(n));
        let border = (0..12_u8, coordinate(n), 0..3_u32).prop_map(move |(face, ix, k)| {
            let iy = (n - 1 - ix + k).saturating_sub(1).min(n - 1);
            (face, ix, iy)
        });
        prop_oneof![anywhere, border]
            .prop_map(move |(face, ix, iy)| Cell::new(nside, face, ix, iy).unwrap())
    })
}

fn unit_interval() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..1.0_f64,
        1 => Just(0.0),
        1 => (0.0..16.0_f64).prop_map(|digits| 10.0_f64.powf(-digits).min(1.0 - f64::EPSILON)),
        1 => (0.0..16.0_f64).prop_map(|digits| 1.0 - 10.0_f64.powf(-digits)),
    ]
}

/// The lower or upper end of a coordinate, or its middle, where cells of twice the resolution meet.
fn edge() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), Just(0.5)]
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    let tiny = || {
        (any::<bool>(), 0.0..320.0_f64).prop_map(|(negative, digits)| {
            let value = 10.0_f64.powf(-digits);
            if negative { -value } else { value }
        })
    };
    let anywhere = (-1.0..1.0_f64, 0.0..TAU).prop_map(|(z, phi)| at(z, phi));
    // Components of all magnitudes: poles, axes and seams at every distance.
    let hostile = (tiny(), tiny(), tiny()).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    let exact = prop::array::uniform3(prop_oneof![Just(0.0), Just(-0.0), Just(1.0), Just(-1.0)])
        .prop_map(DVec3::from_array)
        .prop_filter("zero has no direction", |v| *v != DVec3::ZERO);
    let border = (-4..=4_i32, any::<bool>(), 0.0..TAU).prop_map(|(ulps, south, phi)| {
        let z = 2.0 / 3.0 + f64::from(ulps) * f64::EPSILON / 2.0;
        at(if south { -z } else { z }, phi)
    });
    let seam = (-1.0..1.0_f64, 0..=4_u32, tiny())
        .prop_map(|(z, quarter, offset)| at(z, f64::from(quarter) * FRAC_PI_2 + offset));
    prop_oneof![anywhere, hostile, exact, border, seam].prop_map(|v| unit_direction(v).unwrap())
}

/// Colatitudes: arbitrary, at every distance from the poles, the equator and the borders of the
/// caps, and exactly there.
fn any_theta() -> impl Strategy<Value = f64> {
    let border = (2.0_f64 / 3.0).acos();
    let ends = [0.0, border, FRAC_PI_2, PI - border, PI];
    let near =
        (0..5_usize, -320.0..0.0_f64, any::<bool>()).prop_map(move |(end, digits, below)| {
            let offset = 10.0_f64.powf(digits);
            (ends[end] + if below { -offset } else { offset }).clamp(0.0, PI)
        });
    prop_oneof![0.0..=PI, near, (0..5_usize).prop_map(move |end| ends[end])]
}

/// Longitudes of either sign: near axes, of many turns, and so large that they have no fraction.
fn any_phi() -> impl Strategy<Value = f64> {
    let near_axis =
        (-8..=8_i32, -320.0..0.0_f64, any::<bool>()).prop_map(|(quarter, digits, below)| {
            let offset = 10.0_f64.powf(digits);
            f64::from(quarter) * FRAC_PI_2 + if below { -offset } else { offset }
        });
    let far = (0.0..308.0_f64, any::<bool>()).prop_map(|(digits, west)| {
        let phi = 10.0_f64.powf(digits);
        if west { -phi } else { phi }
    });
    let axis = (-8..=8_i32).prop_map(|quarter| f64::from(quarter) * FRAC_PI_2);
    prop_oneof![8 => -TAU..TAU, 4 => near_axis, 1 => far, 2 => axis, 1 => Just(-0.0), 1 => Just(f64::MAX)]
}

fn at(z: f64, phi: f64) -> DVec3 {
    let radius = ((1.0 - z) * (1.0 + z)).sqrt();
    DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
}

/// Returns both orders of the resolution, or the only one that exists.
fn orders(nside: Nside) -> Vec<Box<dyn PixelOrder>> {
    let mut orders: Vec<Box<dyn PixelOrder>> = vec![Box::new(Ring::new(nside))];
    if let Ok(nested) = Nested::new(nside) {
        orders.push(Box::new(nested));
    }
    orders
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn a_centre_is_in_its_pixel(cell in any_cell()) {
        let (theta, phi) = cell.centre_angles();
        prop_assert!((0.0..TAU).contains(&phi), "{:?}: phi {}", cell, phi);
        for order in orders(cell.nside()) {
            let pixel = order.pixel_of_cell(cell);
            prop_assert!(pixel < order.n_pixels());
            prop_assert_eq!(order.cell(pixel), cell);
            prop_assert_eq!(order.pixel(order.centre(pixel)), pixel, "{:?}", cell);
            prop_assert_eq!(order.pixel_of_angles(theta, phi), Ok(pixel), "{:?}", cell);
            prop_assert_eq!(order.pixel_of_angles(theta, phi - TAU), Ok(pixel), "{:?}", cell);
        }
    }

    #[test]
    fn ends_of_the_numbering(nside in any_nside(), offset in 0..200_u64) {
        let n = u64::from(nside.value());
        let cap = 2 * n * (n - 1);
        let n_pixels = nside.n_pixels();
        for order in orders(nside) {
            for start in [0, cap, cap + 4 * n, cap + 4 * n * n, n_pixels - cap, n_pixels] {
                for pixel in [start.saturating_sub(1 + offset), start + offset] {
                    if pixel < n_pixels {
                        prop_assert_eq!(order.pixel(order.centre(pixel)), pixel, "{:?}", order);
                        prop_assert_eq!(order.pixel_of_cell(order.cell(pixel)), pixel, "{:?}", order);
                    }
                }
            }
        }
    }

    #[test]
    fn orders_convert_to_each_other(depth in 0..=29_u32, fraction in 0..u64::MAX) {
        let nside = Nside::new(1 << depth).unwrap();
        let nested = Nested::new(nside).unwrap();
        let pixel = fraction % nside.n_pixels();
        prop_assert_eq!(nested.from_ring(nested.to_ring(pixel)), pixel);
        prop_assert_eq!(nested.to_ring(nested.from_ring(pixel)), pixel);
        let ring = Ring::new(nside);
        prop_assert_eq!(ring.centre(nested.to_ring(pixel)), nested.centre(pixel));
    }

    #[test]
    fn the_map_inverts_any_direction(dir in any_direction(), nside in any_nside()) {
        let (cell, u, v) = Cell::invert_uniform_point(nside, dir);
        prop_assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v), "{}: {} {}", dir, u, v);
        prop_assert_eq!(Cell::containing(nside, dir), cell);
        let back = cell.uniform_point(u, v);
        // Cell coordinates and the map round once or twice each, in units of at most 2 rad.
        prop_assert!(back.distance(dir) <= 2.0 * DIRECTION_TOLERANCE, "{} came back as {}", dir, back);
    }

    #[test]
    fn a_list_matches_single_lookups_of_directions(
        anywhere in prop::collection::vec(any_direction(), 0..40),
        on_edges in prop::collection::vec((any_cell(), edge(), unit_interval(), any::<[bool; 3]>()), 0..40),
        nside in any_nside(),
    ) {
        // Points on the edges of cells of this resolution, and neighbours one unit in the last
        // place away in one component.
        let on_edges = on_edges.into_iter().map(|(cell, edge, along, nudge)| {
            let n = nside.value();
            let cell = Cell::new(nside, cell.face(), cell.ix() % n, cell.iy() % n).unwrap();
            let (u, v) = if nudge[0] { (edge, along) } else { (along, edge) };
            let dir = cell.uniform_point(u, v);
            match nudge {
                [_, true, true] => DVec3::new(dir.x.next_up(), dir.y.next_down(), dir.z),
                [_, true, false] => DVec3::new(dir.x, dir.y, dir.z.next_up()),
                [_, false, true] => DVec3::new(dir.x, dir.y, dir.z.next_down()),
                _ => dir,
            }
        });
        let dirs: Vec<DVec3> = anywhere.into_iter().chain(on_edges).collect();
        for order in orders(nside) {
            let mut pixels = vec![u64::MAX; dirs.len()];
            order.pixels_into(&dirs, &mut pixels);
            for (dir, pixel) in dirs.iter().zip(pixels) {
                prop_assert_eq!(pixel, order.pixel(*dir), "{:?}: {}", order, dir);
            }
        }
    }

    #[test]
    fn a_list_matches_single_lookups_of_angles(
        angles in prop::collection::vec((any_theta(), any_phi()), 0..70),
        nside in any_nside(),
    ) {
        let angles: Vec<[f64; 2]> = angles.into_iter().map(|(theta, phi)| [theta, phi]).collect();
        for order in orders(nside) {
            let mut pixels = vec![u64::MAX; angles.len()];
            prop_assert_eq!(order.pixels_of_angles_into(&angles, &mut pixels), Ok(()));
            for ([theta, phi], pixel) in angles.iter().zip(pixels) {
                prop_assert_eq!(Ok(pixel), order.pixel_of_angles(*theta, *phi), "{:?}: {} {}", order, theta, phi);
            }
        }
    }

    #[test]
    fn angles_and_their_direction_are_in_the_same_pixel_or_adjacent(theta in any_theta(), phi in -10.0..10.0_f64, nside in any_nside()) {
        let (sin, cos) = theta.sin_cos();
        let dir = DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
        let (cell, u, v) = Cell::invert_uniform_point(nside, dir);
        let found = Cell::containing_angles(nside, theta, phi).unwrap();
        // The reduction of a longitude up to 10 has an error of 4 eps here and in the library; a
        // radian has 1.3 nside pixels.
        let slack = 16.0 * f64::EPSILON * f64::from(nside.value());
        let inside = |w: f64| slack < w && w < 1.0 - slack;
        if inside(u) && inside(v) {
            prop_assert_eq!(found, cell, "theta {}, phi {}, u {}, v {}", theta, phi, u, v);
        } else {
            prop_assert!(found == cell || cell.neighbours().contains(&Some(found)) || sin < 1e-15,
                "theta {}, phi {}: {:?} and {:?}", theta, phi, found, cell);
        }
    }

    #[test]
    fn the_inverse_recovers_cell_and_coordinates(cell in any_cell(), u in unit_interval(), v in unit_interval()) {
        let dir = cell.uniform_point(u, v);
        prop_assert!((dir.length() - 1.0).abs() <= DIRECTION_TOLERANCE, "{:?} {} {}: {}", cell, u, v, dir);
        let (found, found_u, found_v) = Cell::invert_uniform_point(cell.nside(), dir);
        // Directions are rounded to about 1 eps, and a radian has up to 1.3 nside pixels.
        let slack = 8.0 * f64::EPSILON * f64::from(cell.nside().value());
        let inside = |w: f64| slack < w && w < 1.0 - slack;
        if inside(u) && inside(v) {
            prop_assert_eq!(found, cell, "u {}, v {}", u, v);
            prop_assert!((found_u - u).abs() <= slack && (found_v - v).abs() <= slack,
                "{:?}: ({}, {}) came back as ({}, {})", cell, u, v, found_u, found_v);
        } else {
            // Points on an edge may be located in a neighbour, but not further away.
            prop_assert!(found == cell || cell.neighbours().contains(&Some(found)),
                "{:?} {} {}: found in {:?}", cell, u, v, found);
        }
    }

    #[test]
    fn area_is_preserved(cell in cell_of((1..=1000_u32).prop_map(|n| Nside::new(n).unwrap())), u in 0.05..0.95_f64, v in 0.05..0.95_f64) {
        // Central differences of step h, in units of the pixel: truncation h^2 times a third
        // derivative of at most 1/0.05^2 at the pole, rounding eps/h times nside.
        const H: f64 = 1e-5;
        let tolerance = 400.0 * H * H + 4.0 * f64::EPSILON / H * f64::from(cell.nside().value());
        // The derivative of the map is discontinuous where a cap meets the belt.
        let kink = 2.0 / 3.0 - cell.uniform_point(u, v).z.abs();
        prop_assume!(kink.abs() * f64::from(cell.nside().value()) > 4.0 * H);
        let du = (cell.uniform_point(u + H, v) - cell.uniform_point(u - H, v)) / (2.0 * H);
        let dv = (cell.uniform_point(u, v + H) - cell.uniform_point(u, v - H)) / (2.0 * H);
        let ratio = du.cross(dv).dot(cell.uniform_point(u, v)) * cell.uniform_point_pdf();
        prop_assert!((ratio - 1.0).abs() <= tolerance, "{:?} {} {}: {}", cell, u, v, ratio);
    }

    #[test]
    fn neighbours_are_mutual_and_share_corners(cell in any_cell()) {
        let [north, west, south, east] = cell.corners();
        let shared: [&[DVec3]; 8] = [&[south, west], &[west], &[west, north], &[north], &[north, east], &[east], &[east, south], &[south]];
        for (neighbour, shared) in cell.neighbours().into_iter().zip(shared) {
            let Some(neighbour) = neighbour else { continue };
            prop_assert!(neighbour.neighbours().contains(&Some(cell)), "{:?} of {:?}", neighbour, cell);
            prop_assert!(Cell::new(cell.nside(), neighbour.face(), neighbour.ix(), neighbour.iy()).is_ok());
            for corner in shared {
                let found = neighbour.corners().iter().any(|c| c.distance(*corner) <= 2.0 * DIRECTION_TOLERANCE);
                prop_assert!(found, "{:?} of {:?} has no corner {}", neighbour, cell, corner);
            }
        }
    }

    #[test]
    fn antipodes_are_opposite(cell in any_cell(), u in unit_interval(), v in unit_interval()) {
        let other = cell.antipode();
        prop_assert_ne!(other, cell);
        prop_assert_eq!(other.antipode(), cell);
        let (here, there) = (cell.uniform_point(u, v), other.uniform_point(1.0 - v, 1.0 - u));
        prop_assert!((here + there).length() <= 2.0 * DIRECTION_TOLERANCE, "{:?}: {} and {}", cell, here, there);
        for order in orders(cell.nside()) {
            let pixel = order.pixel_of_cell(cell);
            prop_assert_eq!(order.antipode(order.antipode(pixel)), pixel);
        }
    }
}

#[test]
fn every_centre_of_small_grids_is_in_its_pixel() {
    for n in 1..=33 {
        for order in orders(Nside::new(n).unwrap()) {
            for pixel in 0..order.n_pixels() {
                let dir = order.centre(pixel);
                assert_eq!(order.pixel(dir), pixel, "{order:?}: {dir}");
                assert_eq!(order.invert_uniform_point(dir).0, pixel, "{order:?}: {dir}");
            }
        }
    }
}

#[test]
fn lists_match_single_lookups_on_small_grids() {
    for n in [1, 2, 3, 4, 9, 16] {
        for order in orders(Nside::new(n).unwrap()) {
            let dirs: Vec<DVec3> = (0..order.n_pixels())
                .flat_map(|pixel| order.corners(pixel).into_iter().chain([order.centre(pixel)]))
                .collect();
            let mut pixels = vec![u64::MAX; dirs.len()];
            order.pixels_into(&dirs, &mut pixels);
            let one_by_one: Vec<u64> = dirs.iter().map(|dir| order.pixel(*dir)).collect();
            assert_eq!(pixels, one_by_one, "{order:?}");
        }
    }
}

#[test]
#[should_panic(expected = "the output has 16 pixels for 17 directions")]
fn a_list_of_another_length_panics() {
    let order = Ring::new(Nside::new(2).unwrap());
    order.pixels_into(&[DVec3::X; 17], &mut [0; 16]);
}

#[test]
fn centres_next_to_the_poles_keep_their_relative_precision() {
    let n = Nside::MAX;
    let order = Ring::new(Nside::new(n).unwrap());
    for ring in [1_u32, 2, 3, 1000] {
        // 1 - z = ring^2/(3 nside^2) exactly, and sin(theta) = sqrt((1 - z)(1 + z)); here 1 + z is
        // 2 minus at most 1e-12.
        let distance = f64::from(ring) / f64::from(n);
        let one_minus_z = distance * distance / 3.0;
        let expected = (one_minus_z * (2.0 - one_minus_z)).sqrt();
        let pixels = order.ring(ring).unwrap().pixels();
        for pixel in [pixels.start, pixels.end - 1] {
            for pixel in [pixel, order.antipode(pixel)] {
                let dir = order.centre(pixel);
                let got = dir.x.hypot(dir.y);
                assert!(
                    (got - expected).abs() <= 3.0 * f64::EPSILON * expected,
                    "pixel {pixel}: {got:e} against {expected:e}"
                );
            }
        }
    }
}

#[test]
fn poles_are_corners_of_four_pixels() {
    for n in [1, 2, 3, 18, Nside::MAX] {
        for order in orders(Nside::new(n).unwrap()) {
            for pole in [DVec3::Z, DVec3::NEG_Z] {
                let cell = order.cell(order.pixel(pole));
                assert!(cell.corners().contains(&pole), "{order:?}: {cell:?}");
            }
        }
    }
}

#[test]
fn angles_out_of_range_are_rejected() {
    let order = Ring::new(Nside::new(3).unwrap());
    for theta in [-1e-300, 3.2, f64::NAN, f64::INFINITY] {
        assert!(order.pixel_of_angles(theta, 0.0).is_err(), "theta {theta}");
    }
    for phi in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(order.pixel_of_angles(1.0, phi).is_err(), "phi {phi}");
    }
    for phi in [-0.0, -1e-300, -1e300, 1e300, f64::MAX, TAU, -TAU] {
        assert!(order.pixel_of_angles(1.0, phi).unwrap() < order.n_pixels(), "phi {phi}");
    }
}

#[test]
fn the_error_is_that_of_the_first_invalid_pair() {
    let order = Ring::new(Nside::new(3).unwrap());
    for length in [1, 16, 17, 50] {
        for bad in [0, length / 2, length - 1] {
            let mut angles = vec![[1.0, 2.0]; length];
            angles[length - 1] = [f64::NAN, 0.0];
            angles[bad] = [-0.5, 0.0];
            let error = Err(Error::ThetaOutOfRange { theta: -0.5 });
            assert_eq!(order.pixels_of_angles_into(&angles, &mut vec![0; length]), error);
            angles[bad] = [0.5, f64::INFINITY];
            let error = Err(Error::PhiNotFinite { phi: f64::INFINITY });
            assert_eq!(order.pixels_of_angles_into(&angles, &mut vec![0; length]), error);
        }
    }
}

#[test]
#[should_panic(expected = "the output has 3 pixels for 2 pairs of angles")]
fn a_list_of_angles_of_another_length_panics() {
    let order = Ring::new(Nside::new(2).unwrap());
    let _ = order.pixels_of_angles_into(&[[0.0; 2]; 2], &mut [0; 3]);
}

#[test]
fn a_longitude_just_below_zero_is_west_of_the_seam() {
    for n in [1, 5, Nside::MAX] {
        let order = Ring::new(Nside::new(n).unwrap());
        for theta in [0.4, 2.7] {
            let below = order.pixel_of_angles(theta, -1e-15).unwrap();
            let at_zero = order.pixel_of_angles(theta, 0.0).unwrap();
            assert_eq!(order.cell(below).face() % 4, 3, "nside {n}, theta {theta}");
            assert_eq!(order.cell(at_zero).face() % 4, 0, "nside {n}, theta {theta}");
            assert_eq!(order.pixel_of_angles(theta, TAU), Ok(at_zero));
        }
    }
}
