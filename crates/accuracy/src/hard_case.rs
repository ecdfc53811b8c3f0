use crate::{
    Area, Errors, fits, harmonics, indexing, predictions, quality, spectra, square, transforms,
    warps, weights,
};

/// An extreme input at the limits of floating-point numbers, with the bound of its error.
#[derive(Clone, Copy, Debug)]
pub struct HardCase {
    /// The name, which is also that of its test: `colatitudes_down_to_1e_minus_300`.
    pub name: &'static str,
    /// The computed quantity, and the scale of relative errors.
    pub what: &'static str,
    /// The bound of the largest error.
    pub bound: f64,
    /// The derivation of the bound.
    pub reason: &'static str,
    /// Computes the quantity and compares it with its reference.
    pub measure: fn() -> Errors,
}

/// Returns the hard cases of an area.
#[must_use]
pub fn hard_cases(area: Area) -> Vec<HardCase> {
    match area {
        Area::Harmonics => harmonics::hard_cases(),
        Area::Indexing => indexing::hard_cases(),
        Area::Transforms => transforms::hard_cases(),
        Area::Spectra => spectra::hard_cases(),
        Area::Predictions => predictions::hard_cases(),
        Area::Quality => quality::hard_cases(),
        Area::Weights => weights::hard_cases(),
        Area::Fits => fits::hard_cases(),
        Area::Square => square::hard_cases(),
        Area::Warps => warps::hard_cases(),
    }
}
