use std::sync::{Arc, OnceLock};

use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Streams};
use sphvar_spectrum::quality::PairSums;

use super::definition::{measures, values};
use crate::{Errors, Subject};

/// A set with reference values of its measures.
#[derive(Debug)]
pub(super) struct Reference {
    pattern: String,
    set: PointSet,
    is_direct: bool,
    values: OnceLock<Vec<Option<f64>>>,
}

impl Reference {
    pub(super) fn by_definition(pattern: &Pattern, n: usize) -> Self {
        Self::new(pattern, n, false)
    }

    pub(super) fn by_direct_sums(pattern: &Pattern, n: usize) -> Self {
        Self::new(pattern, n, true)
    }

    fn new(pattern: &Pattern, n: usize, is_direct: bool) -> Self {
        let sampler = pattern.build(n, Domain::Sphere).expect("the number of points is valid");
        let mut rng = Streams::new(7, Purpose::Pattern, n).realization(0);
        let set = sampler.sample(&mut rng).expect("a feasible pattern");
        Self { pattern: pattern.name().to_owned(), set, is_direct, values: OnceLock::new() }
    }

    pub(super) fn pattern(&self) -> &str {
        &self.pattern
    }

    pub(super) fn n_points(&self) -> usize {
        self.set.len()
    }

    pub(super) fn words(&self) -> &'static str {
        if self.is_direct {
            "direct sums over all pairs"
        } else {
            "definitions, in part in twice the precision"
        }
    }

    fn values(&self) -> &[Option<f64>] {
        self.values.get_or_init(|| {
            if self.is_direct {
                values(PairSums::direct(&self.set, Domain::Sphere, &()).ok().as_ref())
            } else {
                measures(&self.set)
            }
        })
    }
}

/// The measures of a set by one method.
#[derive(Debug)]
pub(super) struct Measured {
    reference: Arc<Reference>,
    accuracy: Option<f64>,
    sums: Option<PairSums>,
}

impl Measured {
    pub(super) fn new(reference: Arc<Reference>, accuracy: Option<f64>) -> Self {
        Self { reference, accuracy, sums: None }
    }
}

impl Subject for Measured {
    fn run(&mut self) {
        self.sums = sums(&self.reference.set, self.accuracy);
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        push_errors(&mut errors, "", self.sums.as_ref(), self.reference.values());
        errors
    }
}

/// Returns the measures by direct sums, or by fast ones of an accuracy.
pub(super) fn sums(set: &PointSet, accuracy: Option<f64>) -> Option<PairSums> {
    match accuracy {
        None => PairSums::direct(set, Domain::Sphere, &()).ok(),
        Some(accuracy) => PairSums::fast(set, Domain::Sphere, accuracy, &()).ok(),
    }
}

/// Adds the relative errors of measures; infinite where only one of two energies exists. The
/// logarithmic energy, which has terms of both signs, is relative to at least 1.
pub(super) fn push_errors(
    errors: &mut Errors,
    context: &str,
    got: Option<&PairSums>,
    exact: &[Option<f64>],
) {
    let got = values(got);
    errors.push_length(got.len(), exact.len());
    for (i, (got, exact)) in got.into_iter().zip(exact).enumerate() {
        let name = || format!("{context}{}", NAMES[i]);
        match (got, exact) {
            (Some(got), Some(exact)) => {
                let scale = if i == LOGARITHMIC { exact.abs().max(1.0) } else { exact.abs() };
                let off = got - exact;
                errors.push(if off.abs() > 0.0 { off / scale } else { 0.0 }, name);
            }
            (None, None) => errors.push(0.0, name),
            _ => errors.push(f64::INFINITY, name),
        }
    }
}

const LOGARITHMIC: usize = 6;

const NAMES: [&str; 9] = [
    "cap discrepancy",
    "generalized discrepancy",
    "worst-case error, s = 1.5",
    "worst-case error, s = 2",
    "worst-case error, s = 3",
    "worst-case error, s = 4",
    "logarithmic energy",
    "Riesz energy, s = 1",
    "Riesz energy, s = 2",
];
