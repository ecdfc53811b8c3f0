//! Where the curves of the best samplers cross.

use serde::Serialize;
use sphvar_samplers::{Purpose, Streams};
use sphvar_variance::crossover;

use super::candidate::Candidate;

/// Candidates among which crossovers are looked for, the best first.
const BEST: usize = 8;
/// A crossing within this factor of the number of points in question matters.
const NEAR: f64 = 4.0;

/// Where two samplers' predicted variances cross.
#[derive(Debug, Serialize)]
pub(super) struct CrossingRecord {
    better_below: String,
    better_above: String,
    n: f64,
    interval: (f64, f64),
    confidence: f64,
    /// Whether one of the two needs a number of points within a factor of 4.
    is_near: bool,
    /// Whether the better one has at least a tenth less variance at half and at twice the number.
    is_wide: bool,
}

impl CrossingRecord {
    /// Whether it is clear, near the answer and makes a difference.
    pub(super) fn matters(&self) -> bool {
        self.is_near
            && self.is_wide
            && self.confidence >= 0.95
            && self.interval.1 < 4.0 * self.interval.0
    }

    /// The crossover in words.
    pub(super) fn line(&self) -> String {
        let Self { better_above, better_below, n, interval: (from, to), .. } = self;
        format!("{better_above} overtakes {better_below} at N = {n:.0} ({from:.0} to {to:.0})\n")
    }
}

/// The last crossings of the best candidates' curves in the range that both cover.
pub(super) fn between(ranked: &[Candidate], seed: u64) -> Vec<CrossingRecord> {
    let best = &ranked[..ranked.len().min(BEST)];
    let mut found = Vec::new();
    for (i, a) in best.iter().enumerate() {
        for (j, b) in best.iter().enumerate().skip(i + 1) {
            let streams = Streams::new(seed, Purpose::Resample, i * BEST + j);
            let (points_a, points_b) = (a.curve.variance_points(), b.curve.variance_points());
            let Some(crossing) = crossover(&points_a, &points_b, streams) else {
                continue;
            };
            let (above, below) = if crossing.first_is_better_above { (a, b) } else { (b, a) };
            let near = |n: usize| {
                let ratio = n as f64 / crossing.n_points;
                (1.0 / NEAR..=NEAR).contains(&ratio)
            };
            let gap = |n: f64| {
                let ratio = above.curve.interpolate(n).zip(below.curve.interpolate(n));
                ratio.map_or(0.0, |(above, below)| below / above)
            };
            let (before, after) = (gap(0.5 * crossing.n_points), gap(2.0 * crossing.n_points));
            found.push(CrossingRecord {
                better_below: below.curve.pattern().to_string(),
                better_above: above.curve.pattern().to_string(),
                n: crossing.n_points,
                interval: crossing.interval,
                confidence: crossing.confidence,
                is_near: [a, b].into_iter().filter_map(|c| c.n_points).any(near),
                is_wide: (0.0..0.9).contains(&before) && after > 1.0 / 0.9,
            });
        }
    }
    found
}
