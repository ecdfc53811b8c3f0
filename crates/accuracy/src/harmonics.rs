//! Associated Legendre functions and spherical harmonics of single arguments.
//!
//! Errors are relative to the local amplitude: the largest of `|lambda_lm|`, `|lambda_{l-1,m}|` and
//! `|d lambda_lm/d theta|/(l + 1/2)` where the function oscillates, `|lambda_lm|` where it is
//! evanescent. For values stored in `f64` the scale is at least `2^-1022`, below which `f64` has
//! fewer digits.

mod columns;
mod extremes;
mod single;

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{Area, Effort, Subject, Trial};

pub(crate) use extremes::hard_cases;

/// Colatitudes in radians: the poles and the equator with both sides of each, and generic ones.
const COLATITUDES: [f64; 14] = [
    1e-300,
    1e-30,
    1e-8,
    1e-3,
    0.1,
    0.5,
    1.0,
    FRAC_PI_2 - 1e-9,
    FRAC_PI_2,
    2.0,
    2.9,
    3.1,
    PI - 1e-12,
    PI,
];

/// The scale of relative errors.
const AMPLITUDE: &str = "the local amplitude";
/// The name of the computed reference.
const TWICE: &str = "twice the precision";

/// Returns the trials of this area.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let degrees: &[usize] = match effort {
        Effort::Quick => &[20, 200, 2000],
        Effort::Full => &[20, 200, 2000, 20000],
    };
    let mut trials = single::tables();
    for &l in degrees {
        trials.extend(single::trials(l));
        trials.extend(columns::trials(l));
    }
    trials
}

/// Returns the documented error bound of `sphvar-sh` at degree `l`, `4 EPSILON (l + 1)` of the
/// amplitude.
///
/// One EPSILON per step of the recurrence gives (l + 1) EPSILON, m of which come from the power of
/// the sine; the factor covers several roundings per step.
fn documented_bound(l: usize) -> f64 {
    4.0 * f64::EPSILON * (l as f64 + 1.0)
}

/// Returns orders of degree `l` near 0, `l/2` and `l`.
fn orders(l: usize) -> [usize; 6] {
    [0, 1, l / 2, l / 2 + 1, l - 1, l]
}

/// Returns a trial of Legendre functions.
fn trial(
    method: &str,
    case: String,
    count: usize,
    bound: f64,
    reference: &'static str,
    subject: impl Subject + 'static,
) -> Trial {
    Trial {
        area: Area::Harmonics,
        method: method.to_owned(),
        case,
        count: count as f64,
        unit: "values",
        relative_to: AMPLITUDE,
        bound,
        reference,
        subject: Box::new(subject),
    }
}
