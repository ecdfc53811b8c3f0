//! A sampler of any kind in the ranking.

use sphvar_variance::{VariancePoint, interpolate_variance};

use super::candidate::TimedCandidate;
use super::choosable::{Choosable, Density, Details};
use super::question::Question;
use super::reason::Reason;
use super::record::CandidateRecord;

/// A sampler of any kind with its answer to the question.
pub(super) struct Row {
    pub(super) record: CandidateRecord,
    /// The value by which rows are ranked, smallest first.
    pub(super) merit: f64,
    /// The variance and its standard error, including that of the tail.
    pub(super) variance: Option<(f64, f64)>,
    /// The variance of white noise with the same number of points.
    pub(super) white_variance: Option<f64>,
    /// The nominal work of a set per point; measured times vary from run to run.
    pub(super) work: f64,
    /// The predicted variance curve.
    pub(super) points: Vec<VariancePoint>,
    pub(super) is_file: bool,
    pub(super) is_white_noise: bool,
    /// The name in the reason.
    pub(super) name: String,
    pub(super) reason: Option<Reason>,
    pub(super) density: Density,
    /// The densities in tables.
    pub(super) warp: Option<String>,
    /// The variance with as many independent points of the same density, if that is not uniform.
    pub(super) variance_of_density: Option<f64>,
    /// See [`Details::known_to`].
    pub(super) known_to: Option<f64>,
    /// Whether predictions of a higher precision would be more accurate.
    pub(super) is_rough: bool,
}

/// Errors within this share of each other count as the same.
pub(super) const SAME_ERROR: f64 = 0.01;
/// A variance that is less accurate than this share is not recommended where others are.
const MAX_UNKNOWN: f64 = 0.25;
/// The basis of rows whose density is the integrand.
const KNOWN_INTEGRAL: &str = "known integral";

impl Row {
    /// Returns the row of a candidate; `white` is the variance of white noise with a number of points.
    pub(super) fn new<P: Choosable>(
        candidate: &TimedCandidate<P>,
        question: &Question,
        predictor: &P::Predictor<'_>,
        white: &dyn Fn(usize) -> f64,
    ) -> Self {
        let answer = &candidate.answer;
        let pattern = answer.curve.pattern();
        let work = |n: usize| P::nominal_work(pattern, n) / n as f64;
        let at = answer.n_points.and_then(|n| answer.curve.at(n));
        // Without a prediction at `n_points`, the reason is that of the largest number tried.
        let point = at.or(answer.curve.points().last());
        let mut details = point.map(|point| pattern.details(point, predictor)).unwrap_or_default();
        let reason = details.reason.take();
        let known_to = details.known_to;
        let details = if at.is_some() { details } else { Details::default() };
        let mut record = CandidateRecord::new(candidate, &details, question, predictor, white);
        if known_to.is_some() {
            record.basis = KNOWN_INTEGRAL;
        }
        Self {
            record,
            merit: candidate.merit(question),
            variance: answer.variance,
            white_variance: answer.n_points.map(white),
            work: answer.n_points.map_or(f64::INFINITY, work),
            points: answer.curve.variance_points(),
            is_file: pattern.is_file(),
            is_white_noise: pattern.is_white_noise(),
            name: pattern.name(),
            reason,
            density: pattern.density(),
            warp: pattern.warp(),
            variance_of_density: details.variance_of_density,
            known_to,
            is_rough: candidate.is_rough(),
        }
    }

    /// Returns whether the variance is 0, to rounding.
    pub(super) fn is_exact(&self) -> bool {
        self.variance.is_some_and(|(variance, _)| variance <= 0.0)
    }

    /// Returns whether the pattern buys nothing: its error is that of independent points of its density
    /// to 1 %.
    pub(super) fn is_as_independent(&self) -> bool {
        let ratio = self.variance.zip(self.variance_of_density).map(|(v, of)| v.0 / of);
        ratio.is_some_and(|ratio| (ratio.sqrt() - 1.0).abs() <= SAME_ERROR)
    }

    /// Returns whether the variance is known to a quarter, its tail included.
    fn is_accurate(&self) -> bool {
        self.variance.is_some_and(|(variance, stderr)| stderr <= MAX_UNKNOWN * variance)
    }

    /// Returns whether the row may be recommended before others: predicted to a quarter of the variance,
    /// by a density that is not the integrand.
    pub(super) fn is_sure(&self) -> bool {
        self.known_to.is_none() && self.record.basis == "predicted" && self.is_accurate()
    }

    /// Returns the variance at a number of points within the curve.
    pub(super) fn interpolate(&self, n_points: f64) -> Option<f64> {
        interpolate_variance(&self.points, n_points)
    }
}

/// Sorts the rows, best first; ties are broken by variance.
pub(super) fn rank(rows: &mut [Row]) {
    let variance = |row: &Row| row.variance.map_or(f64::INFINITY, |v| v.0);
    rows.sort_by(|a, b| {
        let order = a.merit.total_cmp(&b.merit);
        order.then(variance(a).total_cmp(&variance(b)))
    });
    for (i, row) in rows.iter_mut().enumerate() {
        row.record.rank = i + 1;
    }
}

/// Returns the recommended row: the first, or one that is less expensive to generate and at most
/// 10 % worse. If rows are ranked by total time, it is the first, because that time includes the
/// generation. Rows of inaccurate variance are recommended only if there are no others, extrapolated
/// ones only if none was predicted, and those whose density is the integrand never: they need the
/// integral.
pub(super) fn recommended<'a>(ranked: &'a [Row], question: &Question) -> Option<&'a Row> {
    let sure = |row: &&Row| row.record.basis == "predicted";
    let ranked = || ranked.iter().filter(|row| row.known_to.is_none());
    let any = ranked().find(|row| row.variance.is_some())?;
    let first = || ranked().filter(|row| row.variance.is_some()).filter(sure);
    let first = first().find(|row| row.is_accurate()).or_else(|| first().next()).unwrap_or(any);
    if question.cost_per_sample.is_some() {
        return Some(first);
    }
    let limit = 1.1 * first.merit;
    let near = ranked().filter(|row| row.record.basis == first.record.basis && row.merit <= limit);
    let near = near.filter(|row| row.is_accurate() || !first.is_accurate());
    near.min_by(|a, b| a.work.total_cmp(&b.work))
}

/// Returns whether the recommended row leaves out better ones of inaccurate variance.
pub(super) fn is_best_accurate(ranked: &[Row], recommended: &Row) -> bool {
    let mut better = ranked.iter().take_while(|row| row.merit < recommended.merit);
    let unknown = |row: &Row| row.known_to.is_none() && row.variance.is_some();
    recommended.is_accurate() && better.any(|row| unknown(row) && !row.is_accurate())
}

/// Returns the rows that differ, with the number of others of the same densities that have the same
/// error as the row: of the patterns that buy nothing with a density, the first and `kept` stand for
/// all.
pub(super) fn distinct<'a>(ranked: &'a [Row], kept: Option<&Row>) -> Vec<(&'a Row, usize)> {
    let mut distinct: Vec<(&Row, usize)> = Vec::new();
    for row in ranked {
        let is_kept = kept.is_some_and(|kept| kept.record.sampler == row.record.sampler);
        let is_same = |other: &Row| {
            row.is_as_independent()
                && other.is_as_independent()
                && (&row.warp, row.record.basis) == (&other.warp, other.record.basis)
        };
        match distinct.iter_mut().find(|(other, _)| is_same(other)) {
            Some((_, n_others)) if !is_kept => *n_others += 1,
            _ => distinct.push((row, 0)),
        }
    }
    distinct
}
