//! Transforms of scattered points, to coefficients and back.
//!
//! Both the exact and the fast transform, at every requested accuracy, are compared with the
//! definition in twice the working precision.

mod definition;
mod dense_rings;
mod hard;
mod input;
mod plan;
mod points;
mod subjects;

use std::sync::Arc;

pub(crate) use definition::{Complex, Definition};
pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Trial};
use dense_rings::DenseRings;
use input::Input;
use plan::Accuracy;
use subjects::{ToCoefficients, ToValues};

/// Returns the trials of this area.
///
/// Bounds are the requested accuracy, and [`Accuracy::bound_all_over`] for the exact transform.
/// Values at points are compared one by one: the largest error must satisfy the bound, although a
/// transform with accuracy epsilon guarantees it only for the root mean square of values. The
/// largest of 40 normal numbers exceeds 4 standard deviations once in 400 cases.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let inputs = match effort {
        Effort::Quick => vec![Input::white_noise(1000, 255, 6), Input::white_noise(10_000, 127, 3)],
        Effort::Full => vec![
            Input::white_noise(10_000, 255, 4),
            Input::mirrored(1_000_000, 255, 3),
            Input::white_noise(10_000, 2000, 3),
        ],
    };
    let inputs: Vec<Arc<Input>> = inputs.into_iter().map(Arc::new).collect();
    let accuracies = || Accuracy::all();
    let adjoint = inputs
        .iter()
        .flat_map(|input| accuracies().map(|accuracy| adjoint_trial(Arc::clone(input), accuracy)));
    let synthesis = inputs.iter().take(1).flat_map(|input| {
        accuracies().map(|accuracy| synthesis_trial(Arc::clone(input), accuracy))
    });
    let (pairs, lmax) = match effort {
        Effort::Quick => (2000, 127),
        Effort::Full => (20_000, 1000),
    };
    let rings = Arc::new(Input::pairs(pairs, lmax, 4));
    adjoint.chain(synthesis).chain([dense_rings_trial(rings)]).collect()
}

/// The values on rings are powers of phases, whose errors are like those of the exact transform;
/// the interpolation adds 1e-14.
fn dense_rings_trial(input: Arc<Input>) -> Trial {
    Trial {
        area: Area::Transforms,
        method: format!("dense rings to coefficients, {}", input.size()),
        case: input.name().to_owned(),
        count: input.points().len() as f64,
        unit: "rings",
        relative_to: "the norm of all coefficients",
        bound: Accuracy::Exact.bound_all_over(input.lmax()) + 1e-14,
        reference: "definition in twice the precision, at some orders",
        subject: Box::new(DenseRings::new(input)),
    }
}

fn adjoint_trial(input: Arc<Input>, accuracy: Accuracy) -> Trial {
    Trial {
        area: Area::Transforms,
        method: format!("{} to coefficients, {}", accuracy.kind(), input.size()),
        case: format!("{}{}", input.name(), accuracy.words()),
        count: input.points().len() as f64,
        unit: "points",
        relative_to: "the norm of all coefficients",
        bound: accuracy.bound_all_over(input.lmax()),
        reference: "definition in twice the precision, at some orders",
        subject: Box::new(ToCoefficients::new(input, accuracy)),
    }
}

fn synthesis_trial(input: Arc<Input>, accuracy: Accuracy) -> Trial {
    Trial {
        area: Area::Transforms,
        method: format!("{} to values, {}", accuracy.kind(), input.size()),
        case: format!("{}{}", input.name(), accuracy.words()),
        count: input.points().len() as f64,
        unit: "points",
        relative_to: "the root mean square of the function",
        bound: 4.0 * accuracy.bound_all_over(input.lmax()),
        reference: "definition in twice the precision, at some points",
        subject: Box::new(ToValues::new(input, accuracy)),
    }
}
