//! Quadrature weights of given points, and spectra of weighted points.

mod hard;
mod subjects;

use sphvar_samplers::{Domain, Pattern};
use sphvar_sht::WeightSigns;

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Trial};
use subjects::Rule;

/// The accuracy of the sums of weights times harmonics, relative to the sum of the weights. The
/// iteration ends where its transform no longer resolves the residual: at the roundings of sums
/// over the points, at most 1e-14 for the exact transform, and at the smallest epsilon 1e-13 of the fast
/// one.
const BOUND: f64 = 1e-13;

/// Returns the trials of this area.
///
/// The degrees are those where random points have condition numbers of 2 to 10 and points well apart
/// have nonnegative weights.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    /// Numbers of points and degrees.
    type Sizes = &'static [(usize, usize)];
    let (random, apart): (Sizes, Sizes) = match effort {
        Effort::Quick => (&[(100, 5), (500, 15), (1000, 20)], &[(100, 8), (500, 20)]),
        Effort::Full => (
            &[(100, 5), (500, 15), (1000, 20), (4000, 40), (10_000, 60)],
            &[(100, 8), (500, 20), (1000, 29), (4000, 60)],
        ),
    };
    let any = random.iter().map(|&(n, degree)| {
        trial("least norm", Rule::new(&Pattern::WhiteNoise, n, degree, WeightSigns::Any))
    });
    let nonnegative = apart.iter().map(|&(n, degree)| {
        let rule = Rule::new(&Pattern::FIBONACCI, n, degree, WeightSigns::Nonnegative);
        trial("nonnegative", rule)
    });
    any.chain(nonnegative).collect()
}

fn trial(method: &str, rule: Rule) -> Trial {
    Trial {
        area: Area::Weights,
        method: method.to_owned(),
        case: rule.name(),
        count: rule.points().len() as f64,
        unit: "points",
        relative_to: "the sum of degree 0",
        bound: BOUND,
        reference: "definition in twice the precision",
        subject: Box::new(rule),
    }
}

/// The domain of all inputs.
const DOMAIN: Domain = Domain::Sphere;
