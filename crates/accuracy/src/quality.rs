//! Discrepancies, worst-case errors and energies of point sets.

mod definition;
mod hard;
mod riesz;
mod subjects;

use std::sync::Arc;

use sphvar_samplers::Pattern;
use sphvar_spectrum::quality::PairSums;

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Trial};
use subjects::{Measured, Reference};

/// The requested accuracies of fast sums.
const ACCURACIES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// The bound of direct sums, their documented accuracy.
const DIRECT: f64 = 1e-11;

/// Returns the trials of this area.
///
/// Small sets are compared with the definitions in twice the working precision, larger ones with
/// direct sums. The bounds are the documented accuracies.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let (small, large) = match effort {
        Effort::Quick => (48, 3000),
        Effort::Full => (192, 20_000),
    };
    let mut trials = Vec::new();
    for pattern in [Pattern::WhiteNoise, Pattern::FIBONACCI] {
        let reference = Arc::new(Reference::by_definition(&pattern, small));
        trials.push(trial(&reference, None));
        trials.push(Trial {
            method: "fast, few points".to_owned(),
            ..trial(&reference, Some(PairSums::ACCURACY))
        });
        let reference = Arc::new(Reference::by_direct_sums(&pattern, large));
        trials.extend(ACCURACIES.map(|accuracy| trial(&reference, Some(accuracy))));
    }
    trials.extend(riesz::trials(large));
    trials
}

fn trial(reference: &Arc<Reference>, accuracy: Option<f64>) -> Trial {
    let (method, words) = match accuracy {
        None => ("direct".to_owned(), String::new()),
        Some(accuracy) => {
            (format!("fast, {}", reference.pattern()), format!(", accuracy = {accuracy:e}"))
        }
    };
    Trial {
        area: Area::Quality,
        method,
        case: format!("{} {}{words}", reference.n_points(), reference.pattern()),
        count: reference.n_points() as f64,
        unit: "points",
        relative_to: "each measure",
        bound: accuracy.unwrap_or(DIRECT),
        reference: reference.words(),
        subject: Box::new(Measured::new(Arc::clone(reference), accuracy)),
    }
}
