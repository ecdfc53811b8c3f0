use std::collections::BTreeSet;

use sphvar_samplers::{Pattern, Progress};

use crate::{
    CurvePredictor, Error, PredictedPoint, PredictedVariance, PredictionBudget, RateFit,
    VariancePoint, fit_exact_rate,
};

/// The predicted variance of one pattern as a function of its number of points.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedCurve<F = Pattern, P = PredictedPoint> {
    pattern: F,
    /// Sorted by number of points, which are distinct.
    points: Vec<P>,
    /// The numbers of points whose prediction is less precise than the answer that it led to.
    preliminary: BTreeSet<usize>,
}

impl<F, P: PredictedVariance> PredictedCurve<F, P> {
    /// Returns a curve without points.
    #[must_use]
    pub fn new(pattern: F) -> Self {
        Self { pattern, points: Vec::new(), preliminary: BTreeSet::new() }
    }

    /// Returns the pattern.
    #[must_use]
    pub fn pattern(&self) -> &F {
        &self.pattern
    }

    /// Returns the points, sorted by their distinct numbers of points.
    #[must_use]
    pub fn points(&self) -> &[P] {
        &self.points
    }

    /// Returns the point at a number of points, if present.
    #[must_use]
    pub fn at(&self, n_points: usize) -> Option<&P> {
        let found = self.points.binary_search_by_key(&n_points, P::n_points);
        found.ok().map(|i| &self.points[i])
    }

    /// Returns the point at a number of points, and predicts it if it is not present or preliminary. Work is
    /// ticked as in [`PredictorOn::predict`](crate::PredictorOn::predict).
    ///
    /// # Errors
    ///
    /// Returns the errors of [`CurvePredictor::predict_at`].
    pub fn predict<C: CurvePredictor<F, Point = P> + ?Sized>(
        &mut self,
        predictor: &mut C,
        n_points: usize,
        progress: &dyn Progress,
    ) -> Result<&P, Error> {
        let found = self.points.binary_search_by_key(&n_points, P::n_points);
        let at = match found {
            Ok(at) if !self.is_preliminary(n_points) => at,
            Ok(at) | Err(at) => {
                let budget = predictor.budget();
                self.predict_within(predictor, budget, n_points, progress)?;
                at
            }
        };
        Ok(&self.points[at])
    }

    /// Predicts the variance at a number of points within a budget, unless the point at that number is known to
    /// be the same prediction.
    pub(crate) fn predict_within<C: CurvePredictor<F, Point = P> + ?Sized>(
        &mut self,
        predictor: &mut C,
        budget: PredictionBudget,
        n_points: usize,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        if let Some(point) = self.at(n_points)
            && predictor.is_repeated_by(&self.pattern, point, budget)?
        {
            self.preliminary.remove(&n_points);
            return Ok(());
        }
        let point = predictor.predict_at(&self.pattern, n_points, budget, progress)?;
        self.insert(point);
        Ok(())
    }

    /// Returns whether the point at a number of points is less precise than an answer must be.
    pub(crate) fn is_preliminary(&self, n_points: usize) -> bool {
        self.preliminary.contains(&n_points)
    }

    /// Marks the point at a number of points as less precise than an answer must be.
    pub(crate) fn mark_preliminary(&mut self, n_points: usize) {
        self.preliminary.insert(n_points);
    }

    /// Inserts a point that was predicted before, replacing any at its number of points.
    pub fn insert(&mut self, point: P) {
        self.preliminary.remove(&point.n_points());
        match self.points.binary_search_by_key(&point.n_points(), P::n_points) {
            Ok(at) => self.points[at] = point,
            Err(at) => self.points.insert(at, point),
        }
    }

    /// Returns the curve for predictions of a higher precision by the same predictor: its points only show
    /// which numbers of points clearly suffice or do not, and are predicted again where an answer needs more
    /// and the prediction would differ.
    #[must_use]
    pub fn into_preliminary(mut self) -> Self {
        self.preliminary = self.points.iter().map(P::n_points).collect();
        self
    }

    /// Returns the points with a variance above 0, for fits and crossovers.
    #[must_use]
    pub fn variance_points(&self) -> Vec<VariancePoint> {
        let all = self.points.iter().map(P::variance_point);
        all.filter(|p| p.variance > 0.0).collect()
    }

    /// Returns the power law through the points from a quarter to four times `n_points`, the rate
    /// at this number of points; `None` for fewer than two points or if the variance is 0.
    #[must_use]
    pub fn rate_near(&self, n_points: usize) -> Option<RateFit> {
        if self.at(n_points).is_some_and(|p| p.prediction().variance <= 0.0) {
            return None;
        }
        self.rate_within(0.25 * n_points as f64, 4.0 * n_points as f64)
    }

    /// Returns the power law through the points from `low` to `high` with equal weights, since the
    /// points' own errors are small relative to the deviation of the curve from a power law.
    pub(crate) fn rate_within(&self, low: f64, high: f64) -> Option<RateFit> {
        let within = |p: &VariancePoint| (low..=high).contains(&p.n_points);
        let points = self.variance_points().into_iter().filter(within);
        fit_exact_rate(&points.collect::<Vec<_>>())
    }

    /// Returns the variance at a number of points within the curve, by
    /// [`interpolate_variance`].
    #[must_use]
    pub fn interpolate(&self, n_points: f64) -> Option<f64> {
        interpolate_variance(&self.variance_points(), n_points)
    }
}

/// Returns the variance at a number of points between the first and the last of `points`, by linear
/// interpolation in log N and log Var. The points have variances above 0 and increasing numbers of
/// points.
#[must_use]
pub fn interpolate_variance(points: &[VariancePoint], n_points: f64) -> Option<f64> {
    let at = points.partition_point(|p| p.n_points < n_points);
    let above = points.get(at)?;
    if above.n_points <= n_points {
        return Some(above.variance);
    }
    let below = points.get(at.checked_sub(1)?)?;
    let share = (n_points / below.n_points).ln() / (above.n_points / below.n_points).ln();
    Some(below.variance * (above.variance / below.variance).powf(share))
}
