//! Angular power spectra: of sets, and in closed form.

mod blocks;
mod hard;
mod merging;
mod pair_sums;
mod subjects;
mod zones;

use std::sync::Arc;

use sphvar_samplers::{EqualAreaParameters, Pattern, Placement};

pub(crate) use hard::hard_cases;
pub(crate) use pair_sums::{dot, legendre, legendre_sums, unit};

use crate::{Area, Effort, Trial};
use subjects::{Known, OfSets, Sets};

/// The requested accuracies of fast transforms.
const EPSILONS: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13];

/// Returns the trials of this area.
///
/// An error of epsilon times the norm of all coefficients, spread evenly over them, changes each by
/// epsilon of its mean size, or slightly more where the N of degree 0 contributes. The relative
/// change of the power is twice that, divided by the root of the number of coefficients of a degree
/// in all sets, as their errors partly cancel; see [`Sets::bound`]. The power of strata is a sum of
/// positive weights and terms with a few roundings each. The power of a lattice has twice the
/// relative error of its amplitudes, where it is largest.
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let (n, lmax, count) = match effort {
        Effort::Quick => (192, 64, 4),
        Effort::Full => (400, 128, 4),
    };
    let sets = Arc::new(Sets::new(Pattern::WhiteNoise, n, lmax, count));
    let mut trials = vec![of_sets(&sets, None)];
    trials.extend(EPSILONS.map(|epsilon| of_sets(&sets, Some(epsilon))));
    for (pattern, n, lmax) in [
        (Pattern::FIBONACCI, 400, 80),
        (Pattern::Healpix, 192, 64),
        (Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered }), 2, 60),
        (Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered }), 3, 60),
        (Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered }), 150, 2),
        (Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered }), 1000, 2),
    ] {
        trials.push(known(pattern, n, lmax));
    }
    trials
}

fn of_sets(sets: &Arc<Sets>, epsilon: Option<f64>) -> Trial {
    let (method, words) = match epsilon {
        None => ("sampling and exact", String::new()),
        Some(epsilon) if epsilon >= 5e-7 => {
            ("sampling and fast f32", format!(", epsilon = {epsilon:e}"))
        }
        Some(epsilon) => ("sampling and fast f64", format!(", epsilon = {epsilon:e}")),
    };
    Trial {
        area: Area::Spectra,
        method: method.to_owned(),
        case: format!("{}{words}", sets.name()),
        count: sets.n_points_in_all() as f64,
        unit: "points",
        relative_to: "the power of white noise",
        bound: sets.bound(epsilon),
        reference: "Legendre polynomials of all pairs in twice the precision",
        subject: Box::new(OfSets::new(Arc::clone(sets), epsilon)),
    }
}

fn known(pattern: Pattern, n: usize, lmax: usize) -> Trial {
    let known = Known::new(pattern, n, lmax);
    Trial {
        area: Area::Spectra,
        method: "without sampling".to_owned(),
        case: known.name(),
        count: n as f64,
        unit: "points",
        relative_to: known.relative_to(),
        bound: known.bound(),
        reference: known.reference(),
        subject: Box::new(known),
    }
}
