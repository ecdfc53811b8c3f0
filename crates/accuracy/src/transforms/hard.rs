use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;

use super::input::Input;
use super::plan::Accuracy;
use super::points;
use crate::{Errors, HardCase};

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "points_within_1e_minus_16_and_repeated",
            what: "coefficients to degree 64 by every method, of points that are equal or differ in the last place; \
                   errors relative to the documented bounds",
            bound: 1.0,
            reason: "epsilon times the norm; EPSILON (lmax + 32) for the exact transform, since errors at one place \
                     do not cancel",
            measure: crowded,
        },
        HardCase {
            name: "all_points_at_a_pole",
            what: "coefficients to degree 100 by every method, of 1000 points at one pole and at both; errors relative to \
                   the documented bounds",
            bound: 1.0,
            reason: "epsilon times the norm; EPSILON (lmax + 32) for the exact transform",
            measure: at_poles,
        },
        HardCase {
            name: "ten_million_points_in_one_set",
            what: "coefficients to degree 16 of 10^7 points at seven places by the fast transform, on grids of f64 and \
                   f32; the exact one is left out, as its workspace would be 1.5 GB; errors relative to the documented bounds, \
                   1e-13 and 5e-7 of the norm",
            bound: 1.0,
            reason: "epsilon times the norm for any number of points: long sums are split into short ones, \
                     since plain sums would have roundings of the same sign, EPSILON for each term",
            measure: ten_million,
        },
    ]
}

/// Adds the error of one method's coefficients, relative to its documented bound.
fn push(errors: &mut Errors, input: &Input, accuracy: Accuracy, points: &[DVec3]) {
    let mut alm = Alm::zeros(input.lmax()).expect("a low degree");
    accuracy.plan(input.lmax()).adjoint(points, None, &mut alm);
    let of_all = input.error_of(&alm);
    errors.push(of_all.max() / accuracy.bound(input.lmax()), || {
        format!("{}, {}{}, {}", input.name(), accuracy.kind(), accuracy.words(), of_all.worst())
    });
}

fn crowded() -> Errors {
    const LMAX: usize = 64;
    let mut errors = Errors::default();
    let all = points::crowded();
    let n_places = 6;
    let mut sets: Vec<(&'static str, Vec<DVec3>)> =
        all.chunks(all.len() / n_places).map(|place| ("one place", place.to_vec())).collect();
    sets.push(("six places", all));
    for (name, points) in sets {
        let input = Input::new(name, points, None, LMAX, LMAX);
        for accuracy in Accuracy::all() {
            push(&mut errors, &input, accuracy, input.points());
        }
    }
    errors
}

/// At a pole `lambda_lm` is 0 except for order 0: `sqrt((2l+1)/(4 pi))`, in the south with the sign
/// of the parity of l.
fn at_poles() -> Errors {
    const LMAX: usize = 100;
    let mut errors = Errors::default();
    for (north, south) in [(1000, 0), (0, 1000), (600, 400)] {
        let points = [vec![DVec3::Z; north], vec![DVec3::NEG_Z; south]].concat();
        let mut exact = Alm::zeros(LMAX).expect("a low degree");
        for (l, a) in exact.column_mut(0).iter_mut().enumerate() {
            let sign = if l % 2 == 1 { -1.0 } else { 1.0 };
            let sum = north as f64 + sign * south as f64;
            a.re = sum * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
        }
        for accuracy in Accuracy::all() {
            let mut alm = Alm::zeros(LMAX).expect("a low degree");
            accuracy.plan(LMAX).adjoint(&points, None, &mut alm);
            for (got, exact) in alm.values_mut().iter_mut().zip(exact.values()) {
                *got -= exact;
            }
            let norm = |alm: &Alm| alm.energy_per_degree().iter().sum::<f64>().sqrt();
            errors.push(norm(&alm) / norm(&exact) / accuracy.bound(LMAX), || {
                let (kind, words) = (accuracy.kind(), accuracy.words());
                format!("{north} at the north and {south} at the south pole, {kind}{words}")
            });
        }
    }
    errors
}

fn ten_million() -> Errors {
    const LMAX: usize = 16;
    const N: usize = 10_000_000;
    const PLACES: usize = 7;
    let places = points::white_noise(PLACES);
    let points: Vec<DVec3> = places.iter().copied().cycle().take(N).collect();
    // The first N mod 7 places have one more.
    let count = |place: usize| (N + PLACES - 1 - place) / PLACES;
    let counts: Vec<f64> = (0..PLACES).map(|place| count(place) as f64).collect();
    let input = Input::new("seven places", places, Some(counts), LMAX, LMAX);
    let mut errors = Errors::default();
    for accuracy in [Accuracy::Epsilon(1e-13), Accuracy::Epsilon(5e-7)] {
        push(&mut errors, &input, accuracy, &points);
    }
    errors
}
