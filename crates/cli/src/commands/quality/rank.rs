//! The rank of a set among all patterns of about its number of points.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{Domain, Pattern, Progress as _, Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::quality::{MAX_POINTS_OF_COVERING, Measure, PairSums, Unavailable};
use sphvar_spectrum::{Error, Moments};

use super::Measured;
use crate::commands::choose::is_expensive;
use crate::error::CliError;
use crate::global::Global;
use crate::progress::Progress;

/// The measures of a rank: the cap discrepancy, and the worst-case error for s = 2.
const MEASURES: [Measure; 2] = [Measure::CapDiscrepancy, Measure::WorstCaseError(1)];
/// Realizations of a random pattern: as many as have this number of pairs and take this nominal
/// work, at most 4.
const PAIRS: f64 = 4e7;
const WORK: f64 = 1e6;

/// The place among patterns, 1 for the best.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RankRecord {
    /// By the scaled L2 cap discrepancy.
    pub(super) cap_discrepancy_l2: usize,
    /// By the scaled worst-case error for s = 2.
    pub(super) worst_case_error_2: usize,
    /// The number of sets ranked, this one included.
    pub(super) of: usize,
    /// The other patterns, best first by the cap discrepancy.
    pub(super) patterns: Vec<RankedPattern>,
    /// Patterns that are not ranked, because they are expensive or not available.
    pub(super) left_out: Vec<String>,
}

/// A pattern that others are ranked with.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RankedPattern {
    /// The pattern with its parameters.
    pub(super) sampler: String,
    /// The number of points, the nearest that is valid.
    n: usize,
    /// The L2 cap discrepancy times N^(3/4), the mean over some realizations.
    pub(super) cap_discrepancy_l2: f64,
    /// The worst-case error for s = 2 times N.
    worst_case_error_2: f64,
}

/// Ranks a set among the patterns of about its number of points.
pub(super) fn rank(
    measured: &Measured,
    domain: Domain,
    global: &Global,
    progress: &Progress,
) -> Result<Result<RankRecord, Unavailable>, CliError> {
    let n = measured.n_points();
    if n > MAX_POINTS_OF_COVERING {
        let reason = format!("computed for at most {MAX_POINTS_OF_COVERING} points");
        return Ok(Err(Unavailable { reason }));
    }
    let (mut patterns, mut left_out) = (Vec::new(), Vec::new());
    for pattern in Pattern::ALL {
        if pattern.to_string() == measured.source.text {
            continue;
        }
        progress.stage(&format!("rank: {pattern}"));
        match ranked(&pattern, n, domain, global, progress)? {
            Some(found) => patterns.push(found),
            None => left_out.push(pattern.to_string()),
        }
    }
    let [Some(cap), Some(error)] = MEASURES.map(|measure| measured.quality.mean_scaled(measure))
    else {
        return Ok(Err(Unavailable { reason: "the discrepancy is unavailable".to_owned() }));
    };
    let place = |value: fn(&RankedPattern) -> f64, own: f64| {
        1 + patterns.iter().filter(|p| value(p) < own).count()
    };
    let places = (place(|p| p.cap_discrepancy_l2, cap), place(|p| p.worst_case_error_2, error));
    patterns.sort_by(|a, b| a.cap_discrepancy_l2.total_cmp(&b.cap_discrepancy_l2));
    Ok(Ok(RankRecord {
        cap_discrepancy_l2: places.0,
        worst_case_error_2: places.1,
        of: patterns.len() + 1,
        patterns,
        left_out,
    }))
}

/// Returns the mean scaled measures of a pattern; `None` if it is expensive or not available.
fn ranked(
    pattern: &Pattern,
    n: usize,
    domain: Domain,
    global: &Global,
    progress: &Progress,
) -> Result<Option<RankedPattern>, CliError> {
    let n = pattern.nearest_count(n, domain);
    if is_expensive(pattern, n) {
        return Ok(None);
    }
    let Ok(sampler) = pattern.build(n, domain) else { return Ok(None) };
    let sets = Realizations::unrotated(
        &*sampler,
        Streams::new(global.seed, Purpose::Pattern, pattern.stream_group(n)),
    );
    let count = realizations(&*sampler);
    progress.expect(count as f64 * sampler.nominal_work());
    let mut means = [Moments::default(), Moments::default()];
    for index in 0..count {
        let mut set = sphvar_samplers::PointSet::default();
        match sets.realize_into(index, &mut set, progress) {
            Err(sphvar_samplers::Error::Infeasible { .. }) => return Ok(None),
            other => other.map_err(Error::from)?,
        }
        let sums = PairSums::new(&set, domain, progress)?;
        let values = [sums.cap_discrepancy_l2, sums.worst_case_error[1]];
        for ((mean, measure), value) in means.iter_mut().zip(MEASURES).zip(values) {
            mean.push(value * measure.scale(set.len(), domain));
        }
    }
    let [cap_discrepancy_l2, worst_case_error_2] = means.map(|mean| mean.mean());
    Ok(Some(RankedPattern {
        sampler: pattern.to_string(),
        n,
        cap_discrepancy_l2,
        worst_case_error_2,
    }))
}

/// Returns the number of realizations from which the measures of a pattern are estimated.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 4")]
pub(super) fn realizations(sampler: &dyn Sampler) -> u64 {
    if !sampler.is_random() {
        return 1;
    }
    let pairs = PAIRS / (sampler.n_points() as f64).powi(2);
    pairs.min(WORK / sampler.nominal_work()).clamp(1.0, 4.0) as u64
}
