use sphvar_samplers::{Pattern, Progress};

use crate::required_points::{affordable, ignore_unsupported_count, largest_count_to};
use crate::{
    CurvePredictor, Error, PredictedCurve, PredictedPoint, PredictedVariance, PredictionBudget,
    RequiredPoints, required_points_within,
};

/// The goal by which patterns are ranked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The least variance with at most this number of points, or with the smallest valid count of a
    /// pattern whose valid counts all exceed it.
    Points(usize),
    /// The fewest points with at most this variance.
    Variance {
        /// The largest variance of the integral's estimate that suffices, positive.
        variance: f64,
        /// The maximum number of points.
        max_points: usize,
    },
}

/// A pattern with its predictions and its result for a [`Goal`]; [`rank`] sorts candidates, best
/// first.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern, SamplerFamily};
/// use sphvar_integrands::Harmonic;
/// use sphvar_variance::{Candidate, PredictionBudget, Predictor, Goal};
///
/// let integrand = Harmonic::new(4, 0)?;
/// let mut predictor =
///     Predictor::new(&integrand, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
/// let goal = Goal::Points(192);
/// // Your own types that implement `SamplerFamily` can be ranked together with built-in patterns.
/// let families: [&dyn SamplerFamily; 2] = [&Pattern::WhiteNoise, &Pattern::Jittered];
/// let candidates = Candidate::ranked(families, goal, &mut predictor, &())?;
/// assert_eq!(candidates[0].curve.pattern().to_string(), "jittered");
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate<F = Pattern, P = PredictedPoint> {
    /// The predictions at the numbers of points that were tried.
    pub curve: PredictedCurve<F, P>,
    /// The number of points needed, for [`Goal::Variance`].
    pub required: Option<RequiredPoints>,
    /// The number of points needed, or the valid count used for [`Goal::Points`]; `None` if out of
    /// reach.
    pub n_points: Option<usize>,
    /// The variance at `n_points` and its standard error including that of the tail: predicted, or
    /// extrapolated with an unknown error (NaN).
    pub variance: Option<(f64, f64)>,
}

impl<F: Clone, P: PredictedVariance> Candidate<F, P> {
    /// Returns a pattern with its predictions for a goal. Work is ticked as in
    /// [`PredictorOn::predict`](crate::PredictorOn::predict).
    ///
    /// # Errors
    ///
    /// Returns the errors of [`required_points`](crate::required_points) and [`PredictorOn::predict`](crate::PredictorOn::predict).
    pub fn new<C: CurvePredictor<F, Point = P> + ?Sized>(
        family: F,
        goal: Goal,
        predictor: &mut C,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        Self::with_curve(PredictedCurve::new(family), goal, predictor, progress)
    }

    /// Returns patterns with their predictions for a goal, best first as sorted by [`rank`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::new`].
    pub fn ranked<C: CurvePredictor<F, Point = P> + ?Sized>(
        families: impl IntoIterator<Item = F>,
        goal: Goal,
        predictor: &mut C,
        progress: &dyn Progress,
    ) -> Result<Vec<Self>, Error> {
        let candidates = families.into_iter().map(|f| Self::new(f, goal, predictor, progress));
        let mut candidates = candidates.collect::<Result<Vec<_>, _>>()?;
        rank(&mut candidates, goal);
        Ok(candidates)
    }

    /// Returns a pattern with its predictions for a goal, of which those in `curve` are known.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::new`].
    pub fn with_curve<C: CurvePredictor<F, Point = P> + ?Sized>(
        curve: PredictedCurve<F, P>,
        goal: Goal,
        predictor: &mut C,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let budget = predictor.budget();
        Self::with_curve_within(curve, goal, budget, predictor, progress)
    }

    /// Returns [`Self::with_curve`] from predictions within another budget, such as
    /// [`PredictionBudget::rough`] for patterns of which only the best will be predicted precisely. Numbers of
    /// points are affordable as for [`required_points_within`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::new`].
    pub fn with_curve_within<C: CurvePredictor<F, Point = P> + ?Sized>(
        mut curve: PredictedCurve<F, P>,
        goal: Goal,
        budget: PredictionBudget,
        predictor: &mut C,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let (required, n_points) = match goal {
            Goal::Variance { variance, max_points } => {
                let range = (variance, max_points);
                let required =
                    required_points_within(budget, predictor, &mut curve, range, progress)?;
                (Some(required), required.n_points())
            }
            Goal::Points(n) => (None, Some(around(&mut curve, budget, predictor, n, progress)?)),
        };
        let predicted = n_points.and_then(|n| curve.at(n)).map(P::variance_point);
        let variance = match (predicted, required) {
            (Some(p), _) => Some((p.variance, p.stderr)),
            (None, Some(RequiredPoints::Extrapolated { n_points, fit })) => {
                let ln = (n_points as f64).ln();
                Some(((fit.intercept + fit.slope * ln).exp(), f64::NAN))
            }
            _ => None,
        };
        Ok(Self { curve, required, n_points, variance })
    }
}

impl<F, P> Candidate<F, P> {
    /// Returns whether the variance is 0, to rounding.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.variance.is_some_and(|(variance, _)| variance <= 0.0)
    }

    /// Returns the value by which candidates are ranked, smallest first: the number of points
    /// needed, or the variance; infinite if there is none.
    #[must_use]
    pub fn merit(&self, goal: Goal) -> f64 {
        let merit = match goal {
            Goal::Variance { .. } => self.n_points.map(|n| n as f64),
            Goal::Points(_) => self.variance.map(|v| v.0),
        };
        merit.unwrap_or(f64::INFINITY)
    }
}

/// Sorts candidates, best first: by [`Candidate::merit`], ties by variance, remaining ties in the
/// given order.
pub fn rank<F, P>(candidates: &mut [Candidate<F, P>], goal: Goal) {
    let variance = |c: &Candidate<F, P>| c.variance.map_or(f64::INFINITY, |v| v.0);
    candidates.sort_by(|a, b| {
        let order = a.merit(goal).total_cmp(&b.merit(goal));
        order.then(variance(a).total_cmp(&variance(b)))
    });
}

/// Predicts the variance at the valid count nearest to `n`, and returns that count. For the rate,
/// also predicts roughly, where affordable, at the valid counts nearest to n/2 and n/4.
fn around<F: Clone, C: CurvePredictor<F> + ?Sized>(
    curve: &mut PredictedCurve<F, C::Point>,
    budget: PredictionBudget,
    predictor: &mut C,
    n: usize,
    progress: &dyn Progress,
) -> Result<usize, Error> {
    let pattern = curve.pattern().clone();
    // A count above the budget is used only if the pattern has none below.
    let at = largest_count_to(&|n| predictor.nearest_count(&pattern, n), n)
        .unwrap_or_else(|| predictor.nearest_count(&pattern, n));
    if curve.at(at).is_none() || curve.is_preliminary(at) {
        curve.predict_within(predictor, budget, at, progress)?;
    }
    let rough = budget.rough();
    let affordable = affordable(rough, predictor.budget().rough());
    for n in [n / 4, n / 2] {
        let n = predictor.nearest_count(&pattern, n);
        // A count that the pattern rejects is left out of the curve.
        let is_needed = curve.at(n).is_none() || curve.is_preliminary(n);
        if is_needed && predictor.is_affordable_at(&pattern, n, affordable).unwrap_or(false) {
            match curve.predict_within(predictor, rough, n, progress) {
                Ok(()) => curve.mark_preliminary(n),
                Err(error) => ignore_unsupported_count(&error)?,
            }
        }
    }
    Ok(at)
}
