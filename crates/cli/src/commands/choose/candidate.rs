//! What one pattern needs or achieves.

use std::time::Instant;

use sphvar_samplers::{
    Domain, Pattern, PointSet, Purpose, Realizations, SECONDS_PER_WORK, Streams,
};
use sphvar_variance::{
    Candidate, Goal, PredictedCurve, PredictedPoint, Predictor, RequiredPoints, best_design,
    valid_between,
};

use super::question::Question;
use crate::error::CliError;

/// A pattern with its answer to the question and the time for it.
pub(super) struct TimedCandidate {
    pub(super) answer: Candidate,
    /// Whether it needs more than [`MAX_FACTOR`] times the points of the best, and no more is known.
    pub(super) is_behind: bool,
    pub(super) making: Option<Making>,
    /// Seconds for a set and the values of the integrand at its points.
    pub(super) seconds_in_all: Option<f64>,
}

/// The time for a set.
#[derive(Clone, Copy)]
pub(super) struct Making {
    pub(super) seconds: f64,
    /// Not measured at this number of points, but scaled from a smaller one or by the model of costs.
    pub(super) is_scaled: bool,
}

/// Expensive patterns are not tried with more points than this number of times those of the best. With the
/// largest alpha, sqrt(2), half of the points of alpha = 1 have the same empty degrees: a design behind that
/// by default is behind with every alpha.
pub(super) const MAX_FACTOR: usize = 4;
/// What a unit of nominal work counts beside the seconds of `--cost-per-sample`, by definition.
const UNIT_COST: f64 = 60e-9;
/// The nominal work per point from which on a pattern is expensive.
const EXPENSIVE: f64 = 30.0;

impl TimedCandidate {
    /// The pattern as it is; where `best` is the number of points that the best one needs, an expensive one
    /// only up to four times that.
    pub(super) fn new(
        pattern: Pattern,
        best: Option<usize>,
        question: &Question,
        predictor: &mut Predictor<'_>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let max_points = question.max_points();
        let needed = best.map_or(usize::MAX, |best| best.saturating_mul(MAX_FACTOR));
        if needed < max_points && pattern.nominal_work(needed) >= EXPENSIVE * needed as f64 {
            let curve = PredictedCurve::new(pattern);
            let found = Self::asked(curve, needed, question, predictor, seed)?;
            return Ok(Self { is_behind: found.answer.n_points.is_none(), ..found });
        }
        Self::asked(PredictedCurve::new(pattern), max_points, question, predictor, seed)
    }

    /// The pattern with the parameters that suit the integrand best, if they make it better than it is and
    /// than all others, whose least variance is `best`.
    pub(super) fn tuned(
        self,
        question: &Question,
        predictor: &mut Predictor<'_>,
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
        let Some((pattern, point)) = best_design(predictor, self.answer.curve.pattern(), n, limit)?
        else {
            return Ok(self);
        };
        let mut curve = PredictedCurve::new(pattern);
        curve.insert(point);
        let tuned = Self::asked(curve, n, question, predictor, seed)?;
        Ok(if tuned.merit(question) < self.merit(question) { tuned } else { self })
    }

    fn asked(
        curve: PredictedCurve,
        max_points: usize,
        question: &Question,
        predictor: &mut Predictor<'_>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let goal = question.goal(max_points);
        let answer = Candidate::with_curve(curve, goal, predictor, &())?;
        let n_points = answer.n_points;
        if let (Goal::Points(budget), Some(n)) = (goal, n_points)
            && n > budget
        {
            return Err(CliError::Failed(format!(
                "its smallest number of points is {n}, more than the {budget} of -n"
            )));
        }
        let making = match n_points {
            Some(n) => Some(making(&answer.curve, question.domain, n, seed)?),
            None => None,
        };
        let values = question.cost_per_sample.zip(n_points).map(|(cost, n)| cost * n as f64);
        let seconds_in_all = values.zip(making).map(|(values, making)| values + making.seconds);
        Ok(Self { answer, is_behind: false, making, seconds_in_all })
    }

    /// How the answer was found.
    pub(super) fn basis(&self) -> &'static str {
        match self.answer.required {
            None | Some(RequiredPoints::Predicted { .. }) => "predicted",
            Some(RequiredPoints::Extrapolated { .. }) => "extrapolated",
            Some(_) if self.is_behind => "behind",
            Some(_) => "out of reach",
        }
    }

    /// By what candidates are ranked, the least first: with the time for a value the time for all.
    pub(super) fn merit(&self, question: &Question) -> f64 {
        let goal = question.goal(usize::MAX);
        let all = |cost: f64, n: usize| {
            // By nominal work: measured seconds change from run to run, and the answer must not.
            cost * n as f64 + UNIT_COST * self.answer.curve.pattern().nominal_work(n)
        };
        match (goal, question.cost_per_sample.zip(self.answer.n_points)) {
            (Goal::Variance { .. }, Some((cost, n))) => all(cost, n),
            _ => self.answer.merit(goal),
        }
    }
}

/// Sets that are made for a median.
const TIMED_SETS: u64 = 5;
/// Seconds after which no further set is made.
const TIMED_SECONDS: f64 = 0.2;
/// Points of the largest set that is made for its time.
const MOST_TIMED: usize = 10_000_000;
/// A set that is expected to take longer is not made.
const LONGEST_SET: f64 = 0.2;

/// The time for a set of `n_points`: measured, or scaled from the largest set that was predicted.
fn making(
    curve: &PredictedCurve,
    domain: Domain,
    n_points: usize,
    seed: u64,
) -> Result<Making, CliError> {
    let pattern = curve.pattern();
    let expected = |n: usize| expected_seconds(pattern, n);
    let largest = curve.points().last().map_or(n_points, PredictedPoint::n_points);
    let too_long = largest < n_points && expected(n_points) > LONGEST_SET;
    let timed = if too_long { largest } else { n_points };
    let timed = match valid_between(pattern, domain, 0, MOST_TIMED, MOST_TIMED) {
        Some(most) if timed > MOST_TIMED => most,
        _ => timed,
    };
    if expected(timed) > LONGEST_SET {
        return Ok(Making { seconds: expected(n_points), is_scaled: true });
    }
    let is_scaled = timed < n_points;
    let seconds = median_seconds(pattern, domain, timed, seed)?;
    Ok(Making { seconds: seconds * expected(n_points) / expected(timed), is_scaled })
}

/// The median time for a set on this core, rotation included.
fn median_seconds(
    pattern: &Pattern,
    domain: Domain,
    n_points: usize,
    seed: u64,
) -> Result<f64, CliError> {
    let sampler = pattern.build(n_points, domain).map_err(CliError::failed)?;
    let streams = Streams::new(seed, Purpose::Pattern, pattern.stream_group(n_points));
    let sets = Realizations::rotated(&*sampler, streams);
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

/// Puts the best first. Equal ones go by their variance.
pub(super) fn rank(candidates: &mut [TimedCandidate], question: &Question) {
    let variance = |c: &TimedCandidate| c.answer.variance.map_or(f64::INFINITY, |v| v.0);
    candidates.sort_by(|a, b| {
        let order = a.merit(question).total_cmp(&b.merit(question));
        order.then(variance(a).total_cmp(&variance(b)))
    });
}

/// What to take of the ranked candidates: the first, or one that is cheaper to make and no more than
/// 10 % worse. With the time for all that is the first: it counts the making already. Extrapolated ones are
/// taken only if none was predicted.
pub(super) fn recommended<'a>(
    ranked: &'a [TimedCandidate],
    question: &Question,
) -> Option<&'a TimedCandidate> {
    let sure = |c: &&TimedCandidate| c.basis() == "predicted";
    let any = ranked.iter().find(|c| c.answer.variance.is_some())?;
    let first = ranked.iter().filter(|c| c.answer.variance.is_some()).find(sure).unwrap_or(any);
    if question.cost_per_sample.is_some() {
        return Some(first);
    }
    let limit = 1.1 * first.merit(question);
    let near = ranked.iter().filter(|c| c.basis() == first.basis() && c.merit(question) <= limit);
    // Nominal work, not measured times: these change from run to run.
    let cost = |c: &TimedCandidate| c.answer.n_points.map_or(f64::INFINITY, |n| per_point(c, n));
    near.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// The seconds of making a set, by the nominal work.
fn expected_seconds(pattern: &Pattern, n_points: usize) -> f64 {
    SECONDS_PER_WORK * pattern.nominal_work(n_points)
}

fn per_point(candidate: &TimedCandidate, n_points: usize) -> f64 {
    candidate.answer.curve.pattern().nominal_work(n_points) / n_points as f64
}
