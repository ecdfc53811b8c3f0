//! Methods on the square: transforms between scattered points and Fourier coefficients.
//!
//! The transforms of both types and that of single coordinates, at every requested accuracy, are
//! compared with the definition in twice the working precision.

mod definition;
mod hard;
mod input;
mod subjects;

use std::sync::Arc;

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Subject, Trial};
use input::{Input, Size};
use subjects::{OfCoordinate, ToCoefficients, ToValues};

/// The requested accuracies.
const EPSILONS: [f64; 13] =
    [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];

/// Returns the trials of this area.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    transforms(effort)
}

/// Returns the trials of transforms.
///
/// Bounds are the requested accuracy. For weights of one sign it is that of the norm of all
/// coefficients; half of the compared frequencies are near the highest ones, which have the largest
/// errors. The matrix of values is the adjoint, and its errors of random coefficients are as large.
fn transforms(effort: Effort) -> Vec<Trial> {
    let sizes: &[Size] = match effort {
        Effort::Quick => &[Size { n: 1000, kmax: 32, axis_max: 1000 }],
        Effort::Full => &[
            Size { n: 1000, kmax: 64, axis_max: 10_000 },
            Size { n: 4096, kmax: 128, axis_max: 1 << 17 },
        ],
    };
    let mut trials = Vec::new();
    for size in sizes {
        let input = Arc::new(Input::new(*size));
        for epsilon in EPSILONS {
            let methods: [(&str, usize, &str, Box<dyn Subject>); 3] = [
                (
                    "to coefficients",
                    size.kmax,
                    "coefficients",
                    Box::new(ToCoefficients::new(Arc::clone(&input), epsilon)),
                ),
                (
                    "to values",
                    size.kmax,
                    "values",
                    Box::new(ToValues::new(Arc::clone(&input), epsilon)),
                ),
                (
                    "of one coordinate",
                    size.axis_max,
                    "coefficients",
                    Box::new(OfCoordinate::new(Arc::clone(&input), epsilon)),
                ),
            ];
            for (method, kmax, compared, subject) in methods {
                trials.push(Trial {
                    area: Area::Square,
                    method: format!("{method}, N = {}, kmax = {kmax}", size.n),
                    case: format!("epsilon = {epsilon:e}"),
                    count: size.n as f64,
                    unit: "points",
                    relative_to: relative_to(compared),
                    bound: epsilon,
                    reference: "definition in twice the precision, some of the results",
                    subject,
                });
            }
        }
    }
    trials
}

fn relative_to(compared: &str) -> &'static str {
    if compared == "values" {
        "the root mean square of values"
    } else {
        "the root mean square of coefficients"
    }
}
