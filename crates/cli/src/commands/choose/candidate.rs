//! The result for one pattern.

use std::time::Instant;

use sphvar_samplers::{Ensemble, PointSet, Purpose, SECONDS_PER_WORK, Streams};
use sphvar_variance::{
    Candidate, Goal, IntegrationSpace, PredictedCurve, PredictedPoint, RequiredPoints,
    valid_between,
};

use super::choosable::{Choosable, PredictorOf};
use super::question::Question;
use crate::error::CliError;
use crate::patterns::BandsOf;

/// A pattern with its answer to the question and the time for it.
pub(super) struct TimedCandidate<P: Choosable> {
    pub(super) answer: Candidate<P, PredictedPoint<BandsOf<P>>>,
    /// Whether it needs more than [`MAX_FACTOR`] times the points of the best pattern, in which
    /// case the exact number is unknown.
    pub(super) is_behind: bool,
    pub(super) set_time: Option<SetTime>,
    /// The time for a set and the values of the integrand at its points, in seconds.
    pub(super) seconds_in_all: Option<f64>,
}

/// The time to generate a set.
#[derive(Clone, Copy)]
pub(super) struct SetTime {
    pub(super) seconds: f64,
    /// Whether the time is scaled from a smaller set or taken from the cost model instead of
    /// measured at this number of points.
    pub(super) is_scaled: bool,
}

/// Expensive patterns are tried with at most this multiple of the best pattern's number of points.
/// With the largest alpha, sqrt(2), half of the points of alpha = 1 have the same empty degrees, so
/// a design that is behind with its default alpha is behind with every alpha.
pub(super) const MAX_FACTOR: usize = 4;
/// The seconds of a unit of nominal work, comparable with `--cost-per-sample`, by definition.
const UNIT_COST: f64 = 60e-9;
/// The nominal work per point above which a pattern is expensive.
const EXPENSIVE: f64 = 30.0;

impl<P: Choosable> TimedCandidate<P> {
    /// Returns the pattern unchanged. If `best`, the number of points of the best pattern, is given,
    /// an expensive one is tried with at most four times as many.
    pub(super) fn new(
        pattern: P,
        best: Option<usize>,
        question: &Question,
        predictor: &mut PredictorOf<'_, P>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let max_points = question.max_points();
        let needed = best.map_or(usize::MAX, |best| best.saturating_mul(MAX_FACTOR));
        if needed < max_points && P::nominal_work(&pattern, needed) >= EXPENSIVE * needed as f64 {
            let curve = PredictedCurve::new(pattern);
            let found = Self::answering(curve, needed, question, predictor, seed)?;
            return Ok(Self { is_behind: found.answer.n_points.is_none(), ..found });
        }
        Self::answering(PredictedCurve::new(pattern), max_points, question, predictor, seed)
    }

    /// Returns the pattern with the parameters that suit the integrand best, if they beat both its
    /// defaults and all other patterns, whose minimum variance is `best`.
    pub(super) fn tuned(
        self,
        question: &Question,
        predictor: &mut PredictorOf<'_, P>,
        best: f64,
        seed: u64,
    ) -> Result<Self, CliError> {
        let (Some(n), Some((variance, _))) = (self.answer.n_points, self.answer.variance) else {
            return Ok(self);
        };
        let limit = match question.goal(usize::MAX) {
            Goal::Variance { .. } => variance,
            Goal::Points(_) => variance.min(best),
        };
        let own = self.answer.curve.pattern();
        let Some((pattern, point)) = P::best_design(own, predictor, n, limit)? else {
            return Ok(self);
        };
        let mut curve = PredictedCurve::new(pattern);
        curve.insert(point);
        let tuned = Self::answering(curve, n, question, predictor, seed)?;
        Ok(if tuned.merit(question) < self.merit(question) { tuned } else { self })
    }

    fn answering(
        curve: PredictedCurve<P, PredictedPoint<BandsOf<P>>>,
        max_points: usize,
        question: &Question,
        predictor: &mut PredictorOf<'_, P>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let goal = question.goal(max_points);
        let answer = Candidate::with_curve(curve, goal, predictor, &())?;
        let n_points = answer.n_points;
        if let (Goal::Points(budget), Some(n)) = (goal, n_points)
            && n > budget
        {
            return Err(CliError::Failed(format!(
                "its minimum number of points, {n}, exceeds the sample budget of {budget}"
            )));
        }
        let set_time = match n_points {
            // The sets of a file exist already.
            Some(n) if !answer.curve.pattern().is_file() => {
                Some(set_time(&answer.curve, predictor.space(), n, seed)?)
            }
            _ => None,
        };
        let values = question.cost_per_sample.zip(n_points).map(|(cost, n)| cost * n as f64);
        let seconds_in_all =
            values.map(|values| values + set_time.map_or(0.0, |set_time| set_time.seconds));
        Ok(Self { answer, is_behind: false, set_time, seconds_in_all })
    }

    /// Returns how the answer was obtained.
    pub(super) fn basis(&self) -> &'static str {
        match self.answer.required {
            None | Some(RequiredPoints::Predicted { .. }) => "predicted",
            Some(RequiredPoints::Extrapolated { .. }) => "extrapolated",
            Some(_) if self.is_behind => "behind",
            Some(_) => "out of reach",
        }
    }

    /// Returns the quantity by which candidates are ranked in increasing order; with a time for a
    /// value, it is the total time.
    pub(super) fn merit(&self, question: &Question) -> f64 {
        let goal = question.goal(usize::MAX);
        let all = |cost: f64, n: usize| {
            // Nominal work, because measured seconds vary from run to run and the answer must not.
            cost * n as f64 + UNIT_COST * P::nominal_work(self.answer.curve.pattern(), n)
        };
        match (goal, question.cost_per_sample.zip(self.answer.n_points)) {
            (Goal::Variance { .. }, Some((cost, n))) => all(cost, n),
            _ => self.answer.merit(goal),
        }
    }
}

/// The number of sets that are generated for a median.
const TIMED_SETS: u64 = 5;
/// The time after which no further set is generated, in seconds.
const TIMED_SECONDS: f64 = 0.2;
/// The number of points of the largest set that is timed.
const MAX_TIMED_POINTS: usize = 10_000_000;
/// A set that is expected to take longer than this is not generated, in seconds.
const MAX_SET_SECONDS: f64 = 0.2;

/// Returns the time for a set of `n_points`, measured or scaled from the largest predicted set.
fn set_time<P: Choosable>(
    curve: &PredictedCurve<P, PredictedPoint<BandsOf<P>>>,
    space: P::Space,
    n_points: usize,
    seed: u64,
) -> Result<SetTime, CliError> {
    let pattern = curve.pattern();
    let expected = |n: usize| expected_seconds(pattern, n);
    let largest = curve.points().last().map_or(n_points, PredictedPoint::n_points);
    let too_long = largest < n_points && expected(n_points) > MAX_SET_SECONDS;
    let timed = if too_long { largest } else { n_points };
    let timed = match valid_between(pattern, space, 0, MAX_TIMED_POINTS, MAX_TIMED_POINTS) {
        Some(max_points) if timed > MAX_TIMED_POINTS => max_points,
        _ => timed,
    };
    if expected(timed) > MAX_SET_SECONDS {
        return Ok(SetTime { seconds: expected(n_points), is_scaled: true });
    }
    let is_scaled = timed < n_points;
    let seconds = median_seconds(pattern, space, timed, seed)?;
    Ok(SetTime { seconds: seconds * expected(n_points) / expected(timed), is_scaled })
}

/// Returns the median time for a set on one core, rotation or shift included.
fn median_seconds<P: Choosable>(
    pattern: &P,
    space: P::Space,
    n_points: usize,
    seed: u64,
) -> Result<f64, CliError> {
    let sampler = pattern.build(n_points, space).map_err(CliError::failed)?;
    let sampler = P::Space::sampler(&sampler);
    let streams = Streams::new(seed, Purpose::Pattern, P::Space::stream_group(sampler));
    let sets = P::Space::realizations(sampler, streams);
    let mut set = PointSet::new(Vec::with_capacity(n_points));
    let mut seconds = Vec::new();
    for index in 0..TIMED_SETS {
        let started = Instant::now();
        sets.realize_into(index, &mut set, &()).map_err(CliError::failed)?;
        seconds.push(started.elapsed().as_secs_f64());
        if seconds.iter().sum::<f64>() > TIMED_SECONDS {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[seconds.len() / 2])
}

/// Sorts the candidates, best first; ties are broken by variance.
pub(super) fn rank<P: Choosable>(candidates: &mut [TimedCandidate<P>], question: &Question) {
    let variance = |c: &TimedCandidate<P>| c.answer.variance.map_or(f64::INFINITY, |v| v.0);
    candidates.sort_by(|a, b| {
        let order = a.merit(question).total_cmp(&b.merit(question));
        order.then(variance(a).total_cmp(&variance(b)))
    });
}

/// Returns the recommended candidate: the first, or one that is less expensive to generate and at
/// most 10 % worse. If candidates are ranked by total time, it is the first, because that time
/// includes the generation. An extrapolated candidate is recommended only if none was predicted.
pub(super) fn recommended<'a, P: Choosable>(
    ranked: &'a [TimedCandidate<P>],
    question: &Question,
) -> Option<&'a TimedCandidate<P>> {
    let sure = |c: &&TimedCandidate<P>| c.basis() == "predicted";
    let any = ranked.iter().find(|c| c.answer.variance.is_some())?;
    let first = ranked.iter().filter(|c| c.answer.variance.is_some()).find(sure).unwrap_or(any);
    if question.cost_per_sample.is_some() {
        return Some(first);
    }
    let limit = 1.1 * first.merit(question);
    let near = ranked.iter().filter(|c| c.basis() == first.basis() && c.merit(question) <= limit);
    // Nominal work, because measured times vary from run to run.
    let cost = |c: &TimedCandidate<P>| c.answer.n_points.map_or(f64::INFINITY, |n| per_point(c, n));
    near.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Returns the time to generate a set, in seconds, estimated from the nominal work.
fn expected_seconds<P: Choosable>(pattern: &P, n_points: usize) -> f64 {
    SECONDS_PER_WORK * P::nominal_work(pattern, n_points)
}

fn per_point<P: Choosable>(candidate: &TimedCandidate<P>, n_points: usize) -> f64 {
    P::nominal_work(candidate.answer.curve.pattern(), n_points) / n_points as f64
}
