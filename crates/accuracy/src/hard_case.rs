use crate::{Area, Errors, harmonics, indexing, predictions, spectra, transforms};

/// An input at the edge of what numbers can hold, and the bound that the error keeps there.
#[derive(Clone, Copy, Debug)]
pub struct HardCase {
    /// The name, which is that of its test: `colatitudes_down_to_1e_minus_300`.
    pub name: &'static str,
    /// What is computed, and what errors are relative to.
    pub what: &'static str,
    /// What the largest error must not exceed.
    pub bound: f64,
    /// Why the bound is what it is.
    pub reason: &'static str,
    /// Computes it and compares it with its reference.
    pub measure: fn() -> Errors,
}

/// The hard cases of an area.
#[must_use]
pub fn hard_cases(area: Area) -> Vec<HardCase> {
    match area {
        Area::Harmonics => harmonics::hard_cases(),
        Area::Indexing => indexing::hard_cases(),
        Area::Transforms => transforms::hard_cases(),
        Area::Spectra => spectra::hard_cases(),
        Area::Predictions => predictions::hard_cases(),
    }
}
