//! The crossings of the best samplers' curves that matter for the answer.

use schemars::JsonSchema;
use serde::Serialize;

use super::row::Row;
use crate::commands::crossovers::{CrossoverRecord, crossovers};
use crate::patterns::SamplerName;

/// The number of best candidates that are searched for crossovers.
const BEST: usize = 8;
/// A crossing within this factor of the number of points of the answer is relevant.
const NEAR: f64 = 4.0;

/// A crossing of the predicted variances of two samplers, and its relevance for the answer.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct CrossingRecord {
    #[serde(flatten)]
    pub(super) crossover: CrossoverRecord,
    /// Whether one of the two needs a number of points within a factor of 4.
    is_near: bool,
    /// Whether the better one has at least a tenth less variance at half and at twice the number.
    is_wide: bool,
}

impl CrossingRecord {
    /// Returns whether the crossing is near the answer and the difference is significant.
    pub(super) fn matters(&self) -> bool {
        self.is_near && self.is_wide
    }
}

/// Returns the significant crossings of the best rows' curves in the range that both cover.
pub(super) fn between(ranked: &[Row], seed: u64) -> Vec<CrossingRecord> {
    let best = &ranked[..ranked.len().min(BEST)];
    let named = |row: &Row| SamplerName {
        text: row.record.sampler.clone(),
        label: row.record.label.clone(),
        is_file: row.is_file,
    };
    let curves: Vec<_> = best.iter().map(|row| (named(row), row.points.clone())).collect();
    let judged = |crossover: CrossoverRecord| {
        let of = |wanted: &str| best.iter().find(|row| row.record.sampler == wanted);
        let (above, below) = of(&crossover.better_above).zip(of(&crossover.better_below))?;
        let is_near = [above, below].into_iter().filter_map(|row| row.record.n).any(|n| {
            let ratio = n as f64 / crossover.n;
            (1.0 / NEAR..=NEAR).contains(&ratio)
        });
        let gap = |n: f64| {
            let ratio = above.interpolate(n).zip(below.interpolate(n));
            ratio.map_or(0.0, |(above, below)| below / above)
        };
        let (before, after) = (gap(0.5 * crossover.n), gap(2.0 * crossover.n));
        let is_wide = (0.0..0.9).contains(&before) && after > 1.0 / 0.9;
        Some(CrossingRecord { crossover, is_near, is_wide })
    };
    crossovers(&curves, seed).into_iter().filter_map(judged).collect()
}
