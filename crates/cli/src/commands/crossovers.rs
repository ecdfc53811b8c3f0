//! Where the variance curves of samplers cross, as tables and files show it.

use serde::Serialize;
use sphvar_samplers::{Purpose, Streams};
use sphvar_variance::{Crossover, VariancePoint, crossover};

/// Where two samplers' curves cross.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CrossoverRecord {
    pub(super) better_below: String,
    pub(super) better_above: String,
    pub(super) n: f64,
    pub(super) interval: (f64, f64),
    pub(super) confidence: f64,
}

impl CrossoverRecord {
    /// Whether the resampled curves cross nearly always, and within a factor of 4.
    pub(super) fn is_clear(&self) -> bool {
        self.confidence >= 0.95 && self.interval.1 < 4.0 * self.interval.0
    }

    /// The crossover in a line of text.
    pub(super) fn line(&self) -> String {
        let Self { better_above, better_below, n, interval: (from, to), .. } = self;
        let doubt = if self.is_clear() { "" } else { ", not clear: the curves run together" };
        format!(
            "{better_above} overtakes {better_below} at N = {n:.0} ({from:.0} to {to:.0}{doubt})\n"
        )
    }
}

/// The last crossing of every pair of curves, each a sampler's name with its points by N. Curves that reach
/// the variance 0 are left out.
pub(super) fn crossovers(
    curves: &[(String, Vec<VariancePoint>)],
    seed: u64,
) -> Vec<CrossoverRecord> {
    let mut found = Vec::new();
    for (i, (name_a, a)) in curves.iter().enumerate() {
        for (j, (name_b, b)) in curves.iter().enumerate().skip(i + 1) {
            if a.iter().chain(b).any(|p| p.variance <= 0.0) {
                continue;
            }
            let streams = Streams::new(seed, Purpose::Resample, i * curves.len() + j);
            let Some(Crossover { n_points, interval, confidence, first_is_better_above }) =
                crossover(a, b, streams)
            else {
                continue;
            };
            let (above, below) =
                if first_is_better_above { (name_a, name_b) } else { (name_b, name_a) };
            found.push(CrossoverRecord {
                better_below: below.clone(),
                better_above: above.clone(),
                n: n_points,
                interval,
                confidence,
            });
        }
    }
    found
}
