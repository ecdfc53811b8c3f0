//! The result for one pattern.

use sphvar_variance::{Candidate, Goal, PredictedCurve, RequiredPoints};

use super::choosable::Choosable;
use super::question::Question;
use super::set_time::{SetTime, set_time};
use crate::error::CliError;

/// A pattern with its answer to the question and the time for it.
pub(super) struct TimedCandidate<P: Choosable> {
    pub(super) answer: Candidate<P, P::Point>,
    /// Whether it needs more than [`MAX_FACTOR`] times the points of the best pattern, in which
    /// case the exact number is unknown.
    pub(super) is_behind: bool,
    pub(super) set_time: Option<SetTime>,
    /// The time for a set and the values of the integrand at its points, in seconds.
    pub(super) seconds_in_all: Option<f64>,
}

/// Expensive and warped patterns are tried with at most this multiple of the best pattern's number
/// of points.
/// With the largest alpha, sqrt(2), half of the points of alpha = 1 have the same empty degrees, so
/// a design that is behind with its default alpha is behind with every alpha.
pub(super) const MAX_FACTOR: usize = 4;
/// The seconds of a unit of nominal work, comparable with `--cost-per-sample`, by definition.
const UNIT_COST: f64 = 60e-9;
/// The nominal work per point above which a pattern is expensive.
pub(super) const EXPENSIVE: f64 = 30.0;

impl<P: Choosable> TimedCandidate<P> {
    /// Returns the pattern unchanged. If `best`, the number of points of the best pattern, is given,
    /// an expensive or warped one is tried with at most four times as many.
    pub(super) fn new(
        pattern: P,
        best: Option<usize>,
        question: &Question,
        predictor: &mut P::Predictor<'_>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let max_points = question.max_points();
        let needed = best.map_or(usize::MAX, |best| best.saturating_mul(MAX_FACTOR));
        let is_limited =
            P::IS_LIMITED || P::nominal_work(&pattern, needed) >= EXPENSIVE * needed as f64;
        if needed < max_points && is_limited {
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
        predictor: &mut P::Predictor<'_>,
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
        curve: PredictedCurve<P, P::Point>,
        max_points: usize,
        question: &Question,
        predictor: &mut P::Predictor<'_>,
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
                Some(set_time(&answer.curve, predictor, n, seed)?)
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
