use std::fmt;

use crate::{
    Area, Errors, fits, harmonics, indexing, predictions, quality, spectra, square, transforms,
    warps, weights,
};

/// The amount of work of a suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Several seconds in total.
    Quick,
    /// Several minutes.
    Full,
}

/// A computation that can be run repeatedly and compared with its reference.
pub trait Subject: Send {
    /// Runs the work that is timed. Inputs are prepared beforehand; so are plans and memory if a
    /// caller would keep them, otherwise by the first run. Spectra and predictions are timed as a
    /// whole, as a user calls them: with the sampling of sets and the plan of their transform.
    fn run(&mut self);

    /// Returns the errors of the last run. This may be far more expensive than the run.
    fn errors(&mut self) -> Errors;
}

/// One method on one input.
pub struct Trial {
    /// The area.
    pub area: Area,
    /// The method, which identifies the curve that the trial is a point of: `fast, f64`.
    pub method: String,
    /// The input: `N = 10000, lmax = 255, epsilon = 1e-6`.
    pub case: String,
    /// The number of `unit`s that one run computes.
    pub count: f64,
    /// The unit: `values`, `points`, `directions`.
    pub unit: &'static str,
    /// The scale of relative errors: `the local amplitude`.
    pub relative_to: &'static str,
    /// The bound of the largest error; it is derived in the documentation of the function that
    /// creates the trial.
    pub bound: f64,
    /// The reference: `25-digit table`.
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

/// Returns the trials of an area.
#[must_use]
pub fn trials(area: Area, effort: Effort) -> Vec<Trial> {
    match area {
        Area::Harmonics => harmonics::trials(effort),
        Area::Indexing => indexing::trials(effort),
        Area::Transforms => transforms::trials(effort),
        Area::Spectra => spectra::trials(effort),
        Area::Predictions => predictions::trials(effort),
        Area::Quality => quality::trials(effort),
        Area::Weights => weights::trials(effort),
        Area::Fits => fits::trials(effort),
        Area::Square => square::trials(effort),
        Area::Warps => warps::trials(effort),
    }
}
