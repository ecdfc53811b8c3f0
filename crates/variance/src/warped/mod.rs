//! Patterns of the square that are mapped to directions of a known density: importance sampling.

mod comparison;
mod pattern;
mod point;
mod predictor;
mod realizations;
mod shares;
mod text;

pub use comparison::{LargestSeen, WarpedComparison, WarpedEstimates, WarpedExperiment};
pub use pattern::WarpedPattern;
pub use point::WarpedPoint;
pub(crate) use point::sum;
pub use predictor::WarpedPredictor;
pub use realizations::WarpedRealizations;
pub use shares::best_shares;
pub use text::WarpedText;

/// Returns the number that distinguishes the random streams of a strategy from those of others with
/// the same sampler. The numbers of samplers of built-in patterns are below 2^32 for fewer points
/// than that, so strategies do not collide with them.
fn strategy_group(strategy: usize) -> usize {
    strategy << 48
}
