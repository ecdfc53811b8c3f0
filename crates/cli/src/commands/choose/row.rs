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
    /// The variance with as many independent points of the same density, if that is not uniform.
    pub(super) variance_of_density: Option<f64>,
    /// See [`Details::known_to`].
    pub(super) known_to: Option<f64>,
}

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
            variance_of_density: details.variance_of_density,
            known_to,
        }
    }

    /// Returns whether the variance is 0, to rounding.
    pub(super) fn is_exact(&self) -> bool {
        self.variance.is_some_and(|(variance, _)| variance <= 0.0)
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
/// generation. An extrapolated row is recommended only if none was predicted, and one whose density
/// is the integrand never: it needs the integral.
pub(super) fn recommended<'a>(ranked: &'a [Row], question: &Question) -> Option<&'a Row> {
    let sure = |row: &&Row| row.record.basis == "predicted";
    let ranked = || ranked.iter().filter(|row| row.known_to.is_none());
    let any = ranked().find(|row| row.variance.is_some())?;
    let first = ranked().filter(|row| row.variance.is_some()).find(sure).unwrap_or(any);
    if question.cost_per_sample.is_some() {
        return Some(first);
    }
    let limit = 1.1 * first.merit;
    let near = ranked().filter(|row| row.record.basis == first.record.basis && row.merit <= limit);
    near.min_by(|a, b| a.work.total_cmp(&b.work))
}
