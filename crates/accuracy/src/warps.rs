//! Maps from the square to directions: densities and round trips.
//!
//! Densities of samples and of directions are compared with closed forms: functions of u for lobes,
//! and for luminance maps the map by its definition, with an integral in twice the working
//! precision. Round trips are compared with the point of the square.

mod hard;
mod luminance;
mod subjects;

use std::sync::Arc;

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Subject, Trial};
use subjects::{Densities, Input, Inverses, Samples, inputs};

/// Returns the trials of this area.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let (height, count) = match effort {
        Effort::Quick => (64, 2000),
        Effort::Full => (1024, 100_000),
    };
    inputs(height, count).into_iter().flat_map(|input| of_map(&Arc::new(input), count)).collect()
}

/// Returns the trials of one map.
fn of_map(input: &Arc<Input>, count: usize) -> Vec<Trial> {
    let trial = |method: &str, relative_to, bound, reference, subject| Trial {
        area: Area::Warps,
        method: method.to_owned(),
        case: input.name.clone(),
        count: count as f64,
        unit: "points",
        relative_to,
        bound,
        reference,
        subject,
    };
    let subjects: [Box<dyn Subject>; 3] = [
        Box::new(Samples::new(Arc::clone(input))),
        Box::new(Densities::new(Arc::clone(input))),
        Box::new(Inverses::new(Arc::clone(input))),
    ];
    let [samples, densities, inverses] = subjects;
    let bound = input.bound;
    vec![
        trial("map", "the density", bound, "closed form", samples),
        trial("density", "the density", bound, "closed form", densities),
        trial("inverse", "the side of the square", bound, "the point of the square", inverses),
    ]
}
