//! What one pattern needs or achieves.

use std::time::Instant;

use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_variance::{
    PredictedCurve, PredictedPoint, Predictor, RequiredPoints, best_design, legal_between,
    required_points,
};

use super::question::{Question, Wish};
use crate::error::CliError;

/// A pattern with its predictions and its answer to the question.
pub(super) struct Candidate {
    pub(super) curve: PredictedCurve,
    /// What it needs, if an error was asked for.
    pub(super) required: Option<RequiredPoints>,
    /// The number of points that it needs, or the legal one nearest to that at hand.
    pub(super) n_points: Option<usize>,
    /// Whether it needs more than [`MAX_FACTOR`] times the points of the best, and no more is known.
    pub(super) is_behind: bool,
    /// The variance at this number and its standard error, by prediction or extrapolation.
    pub(super) variance: Option<(f64, f64)>,
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
/// The nominal work per point from which on a pattern is expensive.
const EXPENSIVE: f64 = 30.0;

impl Candidate {
    /// The pattern as it is; where `best` is the number of points that the best one needs, an expensive one
    /// only up to four times that.
    pub(super) fn new(
        pattern: Pattern,
        best: Option<usize>,
        question: &Question,
        predictor: &mut Predictor<'_>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let max_points = match question.wish {
            Wish::Error { max_points, .. } => max_points,
            Wish::Points(_) => usize::MAX,
        };
        let needed = best.map_or(usize::MAX, |best| best.saturating_mul(MAX_FACTOR));
        if needed < max_points && pattern.nominal_work(needed) >= EXPENSIVE * needed as f64 {
            let curve = PredictedCurve::new(pattern);
            let found = Self::answer(curve, needed, question, predictor, seed)?;
            return Ok(Self { is_behind: found.n_points.is_none(), ..found });
        }
        Self::answer(PredictedCurve::new(pattern), max_points, question, predictor, seed)
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
        let (Some(n), Some((variance, _))) = (self.n_points, self.variance) else {
            return Ok(self);
        };
        let limit = match question.wish {
            Wish::Error { .. } => variance,
            Wish::Points(_) => variance.min(best),
        };
        let Some((pattern, point)) = best_design(predictor, self.curve.pattern(), n, limit)? else {
            return Ok(self);
        };
        let mut curve = PredictedCurve::new(pattern);
        curve.insert(point);
        let tuned = Self::answer(curve, n, question, predictor, seed)?;
        Ok(if tuned.merit(question) < self.merit(question) { tuned } else { self })
    }

    fn answer(
        mut curve: PredictedCurve,
        max_points: usize,
        question: &Question,
        predictor: &mut Predictor<'_>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let (required, n_points) = match question.wish {
            Wish::Error { standard_error, .. } => {
                let variance = standard_error * standard_error;
                let required =
                    required_points(predictor, &mut curve, variance, max_points, &|| ())?;
                (Some(required), required.n_points())
            }
            Wish::Points(n) => (None, Some(around(&mut curve, predictor, n)?)),
        };
        let predicted = n_points.and_then(|n| curve.at(n)).map(PredictedPoint::variance_point);
        let variance = match (predicted, required) {
            (Some(p), _) => Some((p.variance, p.stderr)),
            (None, Some(RequiredPoints::Extrapolated { n_points, fit })) => {
                let ln = (n_points as f64).ln();
                Some(((fit.intercept + fit.slope * ln).exp(), f64::NAN))
            }
            _ => None,
        };
        let making = match n_points {
            Some(n) => Some(making(&curve, question.domain, n, seed)?),
            None => None,
        };
        let values = question.cost_per_sample.zip(n_points).map(|(cost, n)| cost * n as f64);
        let seconds_in_all = values.zip(making).map(|(values, making)| values + making.seconds);
        Ok(Self { curve, required, n_points, is_behind: false, variance, making, seconds_in_all })
    }

    /// Whether the variance is 0, to rounding.
    pub(super) fn is_exact(&self) -> bool {
        self.variance.is_some_and(|(variance, _)| variance <= 0.0)
    }

    /// How the answer was found.
    pub(super) fn basis(&self) -> &'static str {
        match self.required {
            None | Some(RequiredPoints::Predicted { .. }) => "predicted",
            Some(RequiredPoints::Extrapolated { .. }) => "extrapolated",
            Some(_) if self.is_behind => "behind",
            Some(_) => "out of reach",
        }
    }

    /// By what candidates are ranked, the least first.
    pub(super) fn merit(&self, question: &Question) -> f64 {
        let merit = match question.wish {
            // By the model of costs: measured seconds change from run to run, and the answer must not.
            Wish::Error { .. } => self.n_points.map(|n| match question.cost_per_sample {
                Some(cost) => cost * n as f64 + self.curve.pattern().seconds(n),
                None => n as f64,
            }),
            Wish::Points(_) => self.variance.map(|v| v.0),
        };
        merit.unwrap_or(f64::INFINITY)
    }
}

/// Predicts at the valid count next to `n` and, roughly and as far as that is affordable, at those next to a
/// half and a quarter of it, for the rate; returns the first.
fn around(
    curve: &mut PredictedCurve,
    predictor: &mut Predictor<'_>,
    n: usize,
) -> Result<usize, CliError> {
    let pattern = curve.pattern().clone();
    let domain = predictor.domain();
    let legal = |n: usize| pattern.nearest_count(n, domain);
    // More points than are at hand only where the pattern has no fewer.
    let fewer = legal_between(&pattern, domain, 0, n.saturating_add(1), n);
    let at = fewer.unwrap_or_else(|| legal(n));
    curve.predict(predictor, at, &|| ())?;
    for n in [n / 4, n / 2].map(legal) {
        let rough = predictor.budget().rough();
        // A number that the pattern refuses is a point less on the curve.
        if curve.at(n).is_none()
            && predictor.is_affordable_within(rough, &pattern, n).unwrap_or(false)
            && let Ok(point) = predictor.predict_within(rough, &pattern, n, &|| ())
        {
            curve.insert(point);
        }
    }
    Ok(at)
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
    let expected = |n: usize| pattern.seconds(n);
    let largest = curve.points().last().map_or(n_points, PredictedPoint::n_points);
    let too_long = largest < n_points && expected(n_points) > LONGEST_SET;
    let timed = if too_long { largest } else { n_points };
    let timed = match legal_between(pattern, domain, 0, MOST_TIMED, MOST_TIMED) {
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
    let mut points = Vec::with_capacity(n_points);
    let mut seconds = Vec::new();
    for index in 0..TIMED_SETS {
        let started = Instant::now();
        sets.realize_into(index, &mut points).map_err(CliError::failed)?;
        seconds.push(started.elapsed().as_secs_f64());
        if seconds.iter().sum::<f64>() > TIMED_SECONDS {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[seconds.len() / 2])
}

/// Puts the best first. Equal ones go by their variance.
pub(super) fn rank(candidates: &mut [Candidate], question: &Question) {
    let variance = |c: &Candidate| c.variance.map_or(f64::INFINITY, |v| v.0);
    candidates.sort_by(|a, b| {
        let order = a.merit(question).total_cmp(&b.merit(question));
        order.then(variance(a).total_cmp(&variance(b)))
    });
}

/// What to take of the ranked candidates: the first, or one that is cheaper to make and no more than
/// 10 % worse. With the time for all that is the first: it counts the making already. Extrapolated ones are
/// taken only if none was predicted.
pub(super) fn recommended<'a>(
    ranked: &'a [Candidate],
    question: &Question,
) -> Option<&'a Candidate> {
    let sure = |c: &&Candidate| c.basis() == "predicted";
    let any = ranked.iter().find(|c| c.variance.is_some())?;
    let first = ranked.iter().filter(|c| c.variance.is_some()).find(sure).unwrap_or(any);
    if question.cost_per_sample.is_some() {
        return Some(first);
    }
    let limit = 1.1 * first.merit(question);
    let near = ranked.iter().filter(|c| c.basis() == first.basis() && c.merit(question) <= limit);
    // Expected times, not measured ones: these change from run to run.
    let cost = |c: &Candidate| c.n_points.map_or(f64::INFINITY, |n| per_point(c, n));
    near.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

fn per_point(candidate: &Candidate, n_points: usize) -> f64 {
    candidate.curve.pattern().seconds(n_points) / n_points as f64
}
