//! Spectra of ensembles on the unit square: one power for each pair {k, -k} of frequencies.

mod axis_ratio;
mod coincidence;
mod estimate;
mod exact;
mod frequency_grid;
mod radial;
#[cfg(test)]
mod tests;
mod transform;

pub use axis_ratio::{AxisRatio, AxisRatioAccumulator};
pub use coincidence::square_tail_power;
pub use estimate::{accumulate_square, accumulate_square_with, estimate_square};
pub use exact::ExactSquareSpectrum;
pub use frequency_grid::frequency_grid;
pub use radial::{RadialAccumulator, RadialSpectrum};
pub use transform::SquareResolution;
pub(crate) use transform::SquareWorkspace;
