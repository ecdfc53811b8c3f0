use std::fmt;

use crate::{Area, Errors, harmonics, indexing, predictions, spectra, transforms};

/// How much work a suite may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Some seconds in all.
    Quick,
    /// Some minutes.
    Full,
}

/// Something that can be run again and again, and compared with its reference.
pub trait Subject: Send {
    /// The work that is timed. Inputs are made before, and so are plans and memory where a caller would keep them, or by
    /// the first run. Spectra and predictions are timed as a whole, as a user asks for them: with the sampling of sets and
    /// the plan of their transform.
    fn run(&mut self);

    /// The errors of what the last run gave. May be far dearer than the run.
    fn errors(&mut self) -> Errors;
}

/// One method on one input.
pub struct Trial {
    /// What it is about.
    pub area: Area,
    /// The method, which is the curve that the trial is a point of: `fast, f64`.
    pub method: String,
    /// The input: `N = 10000, lmax = 255, epsilon = 1e-6`.
    pub case: String,
    /// How many `unit`s one run computes.
    pub count: f64,
    /// What is counted: `values`, `points`, `directions`.
    pub unit: &'static str,
    /// What errors are relative to: `the local amplitude`.
    pub relative_to: &'static str,
    /// What the largest error must not exceed, with its reason in the documentation of whatever makes the trial.
    pub bound: f64,
    /// What the errors are measured against: `25-digit table`.
    pub reference: &'static str,
    /// The work and its check.
    pub subject: Box<dyn Subject>,
}

impl fmt::Debug for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trial")
            .field("area", &self.area)
            .field("method", &self.method)
            .field("case", &self.case)
            .finish_non_exhaustive()
    }
}

/// The trials of an area.
#[must_use]
pub fn trials(area: Area, effort: Effort) -> Vec<Trial> {
    match area {
        Area::Harmonics => harmonics::trials(effort),
        Area::Indexing => indexing::trials(effort),
        Area::Transforms => transforms::trials(effort),
        Area::Spectra => spectra::trials(effort),
        Area::Predictions => predictions::trials(effort),
    }
}
