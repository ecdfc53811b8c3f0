use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Streams};
use sphvar_spectrum::quality::PairSums;

use super::definition::measures;
use super::riesz;
use super::subjects::{push_errors, sums};
use crate::{Errors, HardCase};

const WHAT: &str = "discrepancies, worst-case errors and energies by direct and fast sums; relative, \
                    infinite where an energy of identical points is a number";

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    let case = |name, measure| HardCase {
        name,
        what: WHAT,
        bound: PairSums::ACCURACY,
        reason: "the requested accuracy of fast sums, which direct ones exceed",
        measure,
    };
    let [energies] = riesz::hard_cases();
    vec![
        energies,
        case("measures_of_one_point", || {
            of_sets(&[("", vec![DVec3::new(0.6, 0.0, -0.8)], vec![])])
        }),
        case("measures_of_two_points", two_points),
        case("measures_of_repeated_and_antipodal_points", repeated_and_antipodal),
        case("measures_with_weights_of_mixed_sign_and_scale", mixed_weights),
        case("measures_of_points_1e_minus_7_apart", close_points),
        HardCase {
            what: "the same of 10^6 identical points, relative to those of one point",
            ..case("measures_of_a_million_points_at_a_pole", million)
        },
    ]
}

fn white(n: usize) -> Vec<DVec3> {
    let mut rng = Streams::new(3, Purpose::Pattern, n).realization(0);
    let sampler = Pattern::WhiteNoise.build(n, Domain::Sphere).expect("any number of points");
    sampler.sample(&mut rng).expect("white noise is feasible").points
}

/// Compares named sets with their definitions.
fn of_sets(sets: &[(&str, Vec<DVec3>, Vec<f64>)]) -> Errors {
    let mut errors = Errors::default();
    for (name, points, weights) in sets {
        let set = PointSet { points: points.clone(), weights: weights.clone() };
        let exact = measures(&set);
        for (method, accuracy) in [("direct", None), ("fast", Some(PairSums::ACCURACY))] {
            let context = format!("{name} {method}: ");
            push_errors(&mut errors, &context, sums(&set, accuracy).as_ref(), &exact);
        }
    }
    errors
}

fn two_points() -> Errors {
    let near = DVec3::new(1e-3, 0.0, 1.0).normalize();
    of_sets(&[
        ("antipodes,", vec![DVec3::Z, DVec3::NEG_Z], vec![]),
        ("at a right angle,", vec![DVec3::Y, DVec3::NEG_X], vec![]),
        ("0.001 apart,", vec![DVec3::Z, near], vec![]),
    ])
}

fn repeated_and_antipodal() -> Errors {
    let points = white(12);
    let mut antipodal = points.clone();
    antipodal.extend(points.iter().map(|p| -*p));
    let mut repeated = antipodal.clone();
    repeated.extend_from_slice(&points[3..9]);
    of_sets(&[("antipodal,", antipodal, vec![]), ("repeated,", repeated, vec![])])
}

/// Weights from 1e-303 to 1e-297 of both signs, and some that are 0.
fn mixed_weights() -> Errors {
    let points = white(24);
    let signs = [1.0, -0.7, 0.3, 0.0, -1.0, 1.0];
    let weight = |k: usize| signs[k % 6] * 10f64.powf((k % 7) as f64) * 1e-303;
    let weights = (0..points.len()).map(weight).collect();
    of_sets(&[("", points, weights)])
}

fn close_points() -> Errors {
    let mut points = white(16);
    for k in 0..16 {
        let p = points[k];
        points.push((p + 1e-7 * p.any_orthonormal_vector()).normalize());
    }
    of_sets(&[("", points, vec![])])
}

fn million() -> Errors {
    let one = PointSet::new(vec![DVec3::Z]);
    let mut exact = measures(&one);
    exact.iter_mut().skip(6).for_each(|energy| *energy = None);
    let many = PointSet::new(vec![DVec3::Z; 1_000_000]);
    let mut errors = Errors::default();
    push_errors(&mut errors, "", sums(&many, Some(PairSums::ACCURACY)).as_ref(), &exact);
    errors
}
