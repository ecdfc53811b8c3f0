//! Where the variance curves of samplers cross, as tables and files show it.

use serde::Serialize;
use sphvar_samplers::{Purpose, Streams};
use sphvar_variance::{Crossover, VariancePoint};

/// Where two samplers' curves cross.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CrossoverRecord {
    pub(super) better_below: String,
    pub(super) better_above: String,
    pub(super) n: f64,
    /// The 95 % interval, with the numbers of points that were tried next to the crossing.
    pub(super) interval: (f64, f64),
    /// The share of resampled curves that cross.
    pub(super) confidence: f64,
}

impl CrossoverRecord {
    /// The crossover in a line of text.
    pub(super) fn line(&self) -> String {
        let Self { better_above, better_below, n, interval: (from, to), .. } = self;
        format!("{better_above} overtakes {better_below} at N = {n:.0} ({from:.0} to {to:.0})\n")
    }
}

/// The significant crossings of every pair of curves, each a sampler's name with its points by N. Curves that reach
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
            let record = |crossover: Crossover| {
                let Crossover { n_points, interval, bracket, confidence, .. } = crossover;
                let (above, below) = if crossover.first_is_better_above {
                    (name_a, name_b)
                } else {
                    (name_b, name_a)
                };
                CrossoverRecord {
                    better_below: below.clone(),
                    better_above: above.clone(),
                    n: n_points,
                    interval: (interval.0.min(bracket.0), interval.1.max(bracket.1)),
                    confidence,
                }
            };
            found.extend(sphvar_variance::crossovers(a, b, streams).into_iter().map(record));
        }
    }
    found
}
