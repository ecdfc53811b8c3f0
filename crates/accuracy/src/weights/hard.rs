use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::{Pattern, PointSet, PointSets};
use sphvar_sht::WeightSigns;
use sphvar_spectrum::{Resolution, SpectrumAccumulator, accumulate};

use super::subjects::{points, push_sums, solve};
use super::{BOUND, DOMAIN};
use crate::reference::DoubleDouble;
use crate::transforms::Definition;
use crate::{Errors, HardCase};

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "weights_of_one_point",
            what: "the weight of a single point, which is 4 pi; relative",
            bound: 4.0 * f64::EPSILON,
            reason: "a quotient of a few rounded numbers",
            measure: one_point,
        },
        HardCase {
            name: "weights_of_repeated_and_antipodal_points",
            what: "sums to degree 6 of 60 random points, 30 of them twice and 20 with their antipodes, relative to \
                   that of degree 0; infinite if repeated points differ in weight",
            bound: BOUND,
            reason: "the roundings of sums over the points; repeated points have the same row of the matrix",
            measure: repeated_points,
        },
        HardCase {
            name: "weights_of_points_on_a_cap",
            what: "sums to degree 2 of 400 random points on a cap of 60 degrees, relative to that of degree 0",
            bound: 100.0 * BOUND,
            reason: "the weights of mixed sign are larger than their sum, and so are the roundings of sums over them",
            measure: cap,
        },
        HardCase {
            name: "weights_of_as_many_points_as_harmonics",
            what: "sums to degree 5 of 36 spiral points, relative to that of degree 0",
            bound: BOUND,
            reason: "a square system, whose only solution is found as any other",
            measure: square_system,
        },
        HardCase {
            name: "spectrum_of_weights_of_mixed_sign_and_scale",
            what: "the power to degree 20 of 80 random points with weights of either sign from 1e-200 to 1e200 and \
                   with those times 1e-300, relative to N",
            bound: 64.0 * f64::EPSILON,
            reason: "twice the error of amplitudes, whose roundings are relative to the largest weight",
            measure: mixed_weights,
        },
    ]
}

fn of_rule(points: &[DVec3], degree: usize) -> (Errors, Vec<f64>) {
    let mut errors = Errors::default();
    let weights = solve(points, degree, WeightSigns::Any).map(|rule| rule.weights);
    match &weights {
        Some(weights) => push_sums(&mut errors, points, weights, degree),
        None => errors.push(f64::NAN, || "no weights".to_owned()),
    }
    (errors, weights.unwrap_or_default())
}

fn one_point() -> Errors {
    let mut errors = Errors::default();
    for point in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.48, -0.6, 0.64)] {
        let (_, weights) = of_rule(&[point], 0);
        errors.push_length(weights.len(), 1);
        for weight in weights {
            errors.push(weight / (4.0 * PI) - 1.0, || point.to_string());
        }
    }
    errors
}

fn repeated_points() -> Errors {
    let mut set = points(&Pattern::WhiteNoise, 60);
    set.extend_from_within(..30);
    set.extend(set.clone().iter().skip(30).take(20).map(|p| -*p));
    let (mut errors, weights) = of_rule(&set, 6);
    for (k, pair) in weights.iter().take(30).zip(weights.iter().skip(60)).enumerate() {
        if pair.0.to_bits() != pair.1.to_bits() {
            errors.push(f64::INFINITY, || format!("point {k}: {} and {}", pair.0, pair.1));
        }
    }
    errors
}

fn cap() -> Errors {
    // The area of the cap is 1/4 of the sphere: heights 1/2 to 1.
    let set = points(&Pattern::WhiteNoise, 400);
    let lifted = set.iter().map(|p| {
        let z = 0.75 + 0.25 * p.z;
        let scale = ((1.0 - z * z) / (1.0 - p.z * p.z)).sqrt();
        DVec3::new(scale * p.x, scale * p.y, z)
    });
    of_rule(&lifted.collect::<Vec<_>>(), 2).0
}

fn square_system() -> Errors {
    of_rule(&points(&Pattern::Spiral, 36), 5).0
}

fn mixed_weights() -> Errors {
    const N: usize = 80;
    const LMAX: usize = 20;
    let set = points(&Pattern::WhiteNoise, N);
    let exponents = (0..N).map(|k| [0, 0, -1, 1, -200, 200][k % 6]);
    let signs = (0..N).map(|k| [1.0, -1.0, 1.0][k % 3]);
    let mut errors = Errors::default();
    for scale in [1.0, 1e-300] {
        // With weights of 1e200 those below do not count; without them they do.
        for largest in [200, 1] {
            let weights = exponents.clone().zip(signs.clone()).enumerate().map(|(k, (e, s))| {
                let size = if e > largest { 1.0 } else { 10f64.powi(e) };
                s * size * (1.0 + 0.01 * k as f64) * scale
            });
            let weights: Vec<f64> = weights.collect();
            push_power(&mut errors, &set, weights, LMAX);
        }
    }
    errors
}

/// Adds the errors of the power of one weighted set, relative to N.
fn push_power(errors: &mut Errors, points: &[DVec3], weights: Vec<f64>, lmax: usize) {
    let n = points.len();
    let set = PointSet { points: points.to_vec(), weights: weights.clone() };
    let empty = SpectrumAccumulator::new(DOMAIN, n, lmax);
    let spectrum = PointSets::new(vec![set], DOMAIN).ok().and_then(|sets| {
        let sums = accumulate(&sets, Resolution::new(lmax, n), 0..1, &empty, &());
        sums.and_then(|sums| sums.finish()).ok()
    });
    let power = spectrum.map(|s| s.power().to_vec()).unwrap_or_default();
    errors.push_length(power.len(), lmax + 1);
    let square = |x: f64| DoubleDouble::from(x) * DoubleDouble::from(x);
    let squares = weights.iter().fold(DoubleDouble::ZERO, |sum, &w| sum + square(w));
    let definition = Definition::new(points, Some(&weights));
    let mut energy = vec![DoubleDouble::ZERO; lmax + 1];
    for m in 0..=lmax {
        for (l, a) in (m..).zip(definition.column(m, lmax)) {
            let term = a.re * a.re + a.im * a.im;
            energy[l] += if m == 0 { term } else { term + term };
        }
    }
    let four_pi = DoubleDouble::from(4.0) * DoubleDouble::pi();
    for (l, (got, energy)) in power.into_iter().zip(energy).enumerate() {
        let exact = four_pi * energy / (DoubleDouble::from(2.0 * l as f64 + 1.0) * squares);
        let error = (DoubleDouble::from(got) - exact).value() / n as f64;
        errors.push(error, || format!("l = {l}, largest weight {:e}", weights[5]));
    }
}
