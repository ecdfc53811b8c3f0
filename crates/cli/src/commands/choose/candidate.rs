//! The result for one pattern.

use sphvar_variance::{
    BestDesign, Candidate, CurvePredictor, Goal, PredictedCurve, PredictedVariance,
    PredictionBudget, RequiredPoints, needs_more_points,
};

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
    /// The precision of its predictions.
    pub(super) precision: Precision,
    /// The pattern with other parameters that may be better but whose prediction is too expensive.
    pub(super) unaffordable: Option<P>,
}

/// The precision with which a sampler is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// About 18 % of the variance, which shows that most samplers cannot be among the best.
    Coarse,
    /// About 6 %.
    Rough,
    /// That of `variance` and `compare`, with the same results.
    Full,
}

impl Precision {
    fn budget(self, full: PredictionBudget) -> PredictionBudget {
        match self {
            Self::Coarse => full.rough().rough(),
            Self::Rough => full.rough(),
            Self::Full => full,
        }
    }

    /// Returns the next higher precision.
    pub(super) fn next(self) -> Self {
        match self {
            Self::Coarse => Self::Rough,
            Self::Rough | Self::Full => Self::Full,
        }
    }
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
/// Samplers within this factor of the best compete with it: the least expensive of those within 10 % is
/// recommended.
const COMPETING: f64 = 1.1;
/// A prediction shows that a sampler does not compete only where its merit differs by more than
/// this factor, if it is an estimate, and by more than this number of standard errors.
pub(super) const CLEAR: (f64, f64) = (1.5, 4.0);

impl<P: Choosable> TimedCandidate<P> {
    /// Returns the pattern unchanged. If `best`, the number of points of the best pattern, is given,
    /// an expensive or warped one is tried with at most four times as many.
    pub(super) fn new(
        mut curve: PredictedCurve<P, P::Point>,
        best: Option<usize>,
        question: &Question,
        predictor: &mut P::Predictor<'_>,
        precision: Precision,
        seed: u64,
    ) -> Result<Self, CliError> {
        let max_points = question.max_points();
        let needed = best.map_or(usize::MAX, |best| best.saturating_mul(MAX_FACTOR));
        let is_limited =
            P::IS_LIMITED || P::nominal_work(curve.pattern(), needed) >= EXPENSIVE * needed as f64;
        let budget = precision.budget(predictor.budget());
        if needed < max_points && is_limited {
            if let Goal::Variance { variance, .. } = question.goal(needed) {
                let range = (variance, needed);
                if needs_more_points(budget, predictor, &mut curve, range, &())? {
                    return Ok(Self::behind(curve, precision));
                }
            }
            let found = Self::answering(curve, needed, question, predictor, precision, seed)?;
            return Ok(Self { is_behind: found.answer.n_points.is_none(), ..found });
        }
        Self::answering(curve, max_points, question, predictor, precision, seed)
    }

    /// Returns a pattern that needs more than [`MAX_FACTOR`] times the points of the best one.
    fn behind(curve: PredictedCurve<P, P::Point>, precision: Precision) -> Self {
        let required = Some(RequiredPoints::OutOfReach);
        Self {
            answer: Candidate { curve, required, n_points: None, variance: None },
            is_behind: true,
            set_time: None,
            seconds_in_all: None,
            precision,
            unaffordable: None,
        }
    }

    /// Returns whether a better prediction may place the sampler among those that compete with the best
    /// one, whose merit is at most `best`; false if no prediction would be more accurate.
    pub(super) fn may_compete(&self, question: &Question, best: f64) -> bool {
        let Some((variance, stderr)) = self.answer.variance else { return false };
        let (factor, errors) = CLEAR;
        let (merit, limit) = (self.merit(question), COMPETING * best);
        // The number of points varies by at most the share by which the variance does. The error of an
        // extrapolation is unknown, and the standard error of an estimate from few realizations may be
        // too small.
        let share = if stderr.is_nan() { 0.0 } else { errors * stderr / variance };
        let point = self.answer.n_points.and_then(|n| self.answer.curve.at(n));
        let is_estimate = point.is_none_or(|point| point.prediction().stderr > 0.0);
        let is_near =
            merit * (1.0 - share).max(0.0) <= limit || is_estimate && merit <= factor * limit;
        self.is_rough() && is_near
    }

    /// Returns whether predictions of a higher precision would be more accurate.
    pub(super) fn is_rough(&self) -> bool {
        let point = self.answer.n_points.and_then(|n| self.answer.curve.at(n));
        let is_exact = point.map(P::Point::prediction).is_some_and(|prediction| {
            prediction.total_stderr() == 0.0 && prediction.dof.is_infinite()
        });
        self.precision != Precision::Full && !is_exact
    }

    /// Returns the pattern with the parameters that suit the integrand best, if they beat both its
    /// defaults and all other patterns, whose minimum variance is `best.0` and whose minimum number of
    /// points is `best.1`.
    ///
    /// Half of the points have the same empty degrees with the largest alpha, so that a pattern
    /// with more than twice the points of the others stays behind them.
    pub(super) fn tuned(
        self,
        question: &Question,
        predictor: &mut P::Predictor<'_>,
        (best, min_points): (f64, Option<usize>),
        seed: u64,
    ) -> Result<Self, CliError> {
        let (Some(n), Some((variance, _))) = (self.answer.n_points, self.answer.variance) else {
            return Ok(self);
        };
        if min_points.is_some_and(|min| n as f64 > 2.0 * COMPETING * min as f64) {
            return Ok(self);
        }
        let limit = match question.goal(usize::MAX) {
            Goal::Variance { .. } => variance,
            Goal::Points(_) => variance.min(best),
        };
        let own = self.answer.curve.pattern();
        let BestDesign { best, unaffordable } = P::best_design(own, predictor, n, limit)?;
        let own = Self { unaffordable: unaffordable.clone(), ..self };
        let Some((pattern, point)) = best else { return Ok(own) };
        let mut curve = PredictedCurve::new(pattern);
        curve.insert(point);
        let tuned = Self::answering(curve, n, question, predictor, Precision::Full, seed)?;
        let is_better = tuned.merit(question) < own.merit(question);
        Ok(if is_better { Self { unaffordable, ..tuned } } else { own })
    }

    fn answering(
        curve: PredictedCurve<P, P::Point>,
        max_points: usize,
        question: &Question,
        predictor: &mut P::Predictor<'_>,
        precision: Precision,
        seed: u64,
    ) -> Result<Self, CliError> {
        let goal = question.goal(max_points);
        let budget = precision.budget(predictor.budget());
        let answer = Candidate::with_curve_within(curve, goal, budget, predictor, &())?;
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
        Ok(Self {
            answer,
            is_behind: false,
            set_time,
            seconds_in_all,
            precision,
            unaffordable: None,
        })
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
