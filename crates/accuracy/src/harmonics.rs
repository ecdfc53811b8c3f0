//! Associated Legendre functions and spherical harmonics of single arguments.
//!
//! Errors are relative to the local amplitude: the largest of `|lambda_lm|`, `|lambda_{l-1,m}|` and
//! `|d lambda_lm/d theta|/(l + 1/2)` where the function oscillates, `|lambda_lm|` where it is evanescent. What `f64` has to hold is compared with at least `2^-1022`,
//! below which `f64` has fewer digits.

mod columns;
mod extremes;
mod single;

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{Area, Effort, Subject, Trial};

pub(crate) use extremes::hard_cases;

/// Colatitudes, radians: the poles, the equator and both sides of them, and ordinary ones.
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

/// What errors are relative to.
const AMPLITUDE: &str = "the local amplitude";
/// The name of the reference of computed values.
const TWICE: &str = "twice the precision";

/// The trials of this area.
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

/// What `sphvar-sh` promises for degree `l`, `4 EPSILON (l + 1)` of the amplitude.
///
/// One EPSILON a step of the recurrence would be (l + 1) EPSILON, and m of them come from the power of the sine; the factor
/// is for what rounds more than once in a step.
fn promise(l: usize) -> f64 {
    4.0 * f64::EPSILON * (l as f64 + 1.0)
}

/// Orders of degree `l` near 0, `l/2` and `l`.
fn orders(l: usize) -> [usize; 6] {
    [0, 1, l / 2, l / 2 + 1, l - 1, l]
}

/// A trial of Legendre functions.
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
