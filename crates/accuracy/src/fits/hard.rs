use glam::DVec3;
use sphvar_samplers::Pattern;
use sphvar_sht::FitError;

use super::bound;
use super::subjects::{fit, function, norm, points, push_coefficients};
use crate::{Errors, HardCase};

/// The amplitude of large noise.
const NOISE: f64 = 1e6;

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "fit_of_points_on_a_cap",
            what: "a fit to degree 10 of 400 points on a cap of 3 degrees must be an error, which states a ridge that \
                   limits the condition number to 50; infinite otherwise",
            bound: 0.0,
            reason: "either holds or does not",
            measure: cap,
        },
        HardCase {
            name: "fit_of_as_many_points_as_harmonics",
            what: "coefficients to degree 5 of values at 36 spiral points, relative to their norm",
            bound: bound(10.0),
            reason: "the gradient at which the iteration ends times the squared condition number, about 5",
            measure: square_system,
        },
        HardCase {
            name: "fit_of_repeated_points",
            what: "coefficients to degree 5 of values at 100 random points, 40 of them three times and 20 with their \
                   antipodes, relative to their norm",
            bound: bound(10.0),
            reason: "the gradient at which the iteration ends times the squared condition number",
            measure: repeated_points,
        },
        HardCase {
            name: "fit_of_noise_of_1e6",
            what: "coefficients to degree 8 of values with noise of amplitude 1e6 at 400 random points, less those of the \
                   noise, relative to 1e6",
            bound: bound(10.0),
            reason: "fits are linear; errors are relative to the largest value",
            measure: large_noise,
        },
    ]
}

fn of_points(points: &[DVec3], lmax: usize) -> Errors {
    let values: Vec<f64> = points.iter().map(|p| function(*p)).collect();
    let mut errors = Errors::default();
    push_coefficients(&mut errors, fit(points, &values, lmax, 0.0).ok().as_ref());
    errors
}

fn cap() -> Errors {
    let set = points(&Pattern::WhiteNoise, 400);
    let cap: Vec<DVec3> = set.iter().map(|p| (0.05 * p + DVec3::Z).normalize()).collect();
    let values: Vec<f64> = cap.iter().map(|p| function(*p)).collect();
    let mut errors = Errors::default();
    let result = fit(&cap, &values, 10, 0.0);
    let stated = match result {
        Err(FitError::IllConditioned { condition, ridge, .. }) if condition > 100.0 => Some(ridge),
        _ => None,
    };
    let with_ridge = stated.and_then(|ridge| fit(&cap, &values, 10, ridge).ok());
    let is_limited = with_ridge.is_some_and(|fit| fit.condition < 50.0);
    errors.push(if is_limited { 0.0 } else { f64::INFINITY }, || format!("ridge {stated:?}"));
    errors
}

fn square_system() -> Errors {
    of_points(&points(&Pattern::Spiral, 36), 5)
}

fn repeated_points() -> Errors {
    let mut set = points(&Pattern::WhiteNoise, 100);
    set.extend_from_within(..40);
    set.extend_from_within(..40);
    set.extend(set.clone().iter().skip(40).take(20).map(|p| -*p));
    of_points(&set, 5)
}

fn large_noise() -> Errors {
    let set = points(&Pattern::WhiteNoise, 400);
    // The fraction of multiples of an irrational number.
    let noise = |k: usize| NOISE * (2.0 * (k as f64 * 0.754_877_666_246_692_7).fract() - 1.0);
    let noise: Vec<f64> = (0..set.len()).map(noise).collect();
    let noisy: Vec<f64> = set.iter().zip(&noise).map(|(p, e)| function(*p) + e).collect();
    let mut errors = Errors::default();
    let both = fit(&set, &noisy, 8, 0.0).ok().zip(fit(&set, &noise, 8, 0.0).ok());
    let difference = both.map(|(mut fit, noise)| {
        let values = fit.alm.values_mut().iter_mut().zip(noise.alm.values());
        values.for_each(|(a, b)| *a -= b);
        fit
    });
    let mut absolute = Errors::default();
    push_coefficients(&mut absolute, difference.as_ref());
    errors.push(absolute.max() * norm() / NOISE, || absolute.worst().to_owned());
    errors
}
