//! Pair correlation, Ripley's functions and differentials of point sets.

mod accumulator;
mod angle_bins;
mod differentials;
mod near_pairs;
mod smoothing;
#[cfg(test)]
mod tests;

pub use accumulator::{PairCorrelation, PairCorrelationAccumulator};
pub use angle_bins::AngleBins;
pub use differentials::{DifferentialAccumulator, Differentials, LocalDensity};
pub use smoothing::HeatSmoothing;
