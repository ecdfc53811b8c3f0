//! Least-squares fits of scattered values.

mod hard;
mod subjects;

use sphvar_samplers::{Domain, Pattern};

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Trial};
use subjects::Problem;

/// The domain of all inputs.
const DOMAIN: Domain = Domain::Sphere;

/// The error of coefficients: 1e-12, the gradient at which the iteration ends, times the square of
/// the condition number.
const fn bound(condition: f64) -> f64 {
    1e-12 * condition * condition
}

/// Returns the trials of this area: random points of condition numbers from 2 to 40.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let sizes: &[(usize, usize, f64)] = match effort {
        Effort::Quick => &[(100, 5, 10.0), (1000, 10, 3.0), (1000, 20, 20.0)],
        Effort::Full => &[
            (100, 5, 10.0),
            (1000, 10, 3.0),
            (1000, 20, 20.0),
            (10_000, 30, 5.0),
            (10_000, 60, 60.0),
            (100_000, 60, 3.0),
            (100_000, 200, 60.0),
        ],
    };
    let trial = |&(n, lmax, condition): &(usize, usize, f64)| Trial {
        area: Area::Fits,
        method: format!("condition < {condition}"),
        case: format!("N = {n}, lmax = {lmax}"),
        count: n as f64,
        unit: "points",
        relative_to: "the norm of the coefficients",
        bound: bound(condition),
        reference: "closed form",
        subject: Box::new(Problem::new(&Pattern::WhiteNoise, n, lmax, condition)),
    };
    sizes.iter().map(trial).collect()
}
