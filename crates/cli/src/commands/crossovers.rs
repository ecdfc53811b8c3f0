//! The crossings of samplers' variance curves, for tables and files.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{Purpose, Streams};
use sphvar_variance::{Crossover, VariancePoint};

use crate::patterns::SamplerName;
use crate::report::number;

/// A crossing of the variance curves of two samplers.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct CrossoverRecord {
    /// The sampler of less variance at fewer points.
    pub(super) better_below: String,
    /// The sampler of less variance at more points.
    pub(super) better_above: String,
    /// The names of both in tables.
    #[serde(skip)]
    labels: [String; 2],
    /// The number of points at which the curves cross; it need not be whole.
    pub(super) n: f64,
    /// The 95 % interval of `n`, extended to the numbers of points that were tried next to the
    /// crossing.
    pub(super) interval: (f64, f64),
    /// The share of resampled curves that cross, from 0 to 1.
    pub(super) confidence: f64,
}

impl CrossoverRecord {
    /// Returns the crossover as a line of text.
    pub(super) fn line(&self) -> String {
        let Self { labels: [below, above], n, interval, .. } = self;
        let interval = number::interval(Some(*interval), number::count);
        format!("{above} overtakes {below} at N = {} ({interval})\n", number::count(*n))
    }
}

/// Returns the significant crossings of every pair of curves, each given by a sampler and its
/// points by N. Curves that reach the variance 0 are omitted.
pub(super) fn crossovers(
    curves: &[(SamplerName, Vec<VariancePoint>)],
    seed: u64,
) -> Vec<CrossoverRecord> {
    let mut found = Vec::new();
    for (i, (sampler_a, a)) in curves.iter().enumerate() {
        for (j, (sampler_b, b)) in curves.iter().enumerate().skip(i + 1) {
            if a.iter().chain(b).any(|p| p.variance <= 0.0) {
                continue;
            }
            let streams = Streams::new(seed, Purpose::Resample, i * curves.len() + j);
            let record = |crossover: Crossover| {
                let Crossover { n_points, interval, bracket, confidence, .. } = crossover;
                let (above, below) = if crossover.first_is_better_above {
                    (sampler_a, sampler_b)
                } else {
                    (sampler_b, sampler_a)
                };
                CrossoverRecord {
                    better_below: below.text.clone(),
                    better_above: above.text.clone(),
                    labels: [below.label.clone(), above.label.clone()],
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
