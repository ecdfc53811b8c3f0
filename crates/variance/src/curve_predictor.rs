use sphvar_samplers::{Progress, SamplerFamily};

use crate::space::{Distribution, IntegrationSpace};
use crate::{Error, PredictedPoint, PredictedVariance, PredictionBudget, PredictorOn};

/// Predicts the variance of a pattern `F` at any number of points, from which curves, required
/// numbers of points and ranks follow.
///
/// [`PredictorOn`] a space implements it for the patterns of that space.
pub trait CurvePredictor<F> {
    /// A prediction at one number of points.
    type Point: PredictedVariance;

    /// Returns the precision and the work of the predictions.
    fn budget(&self) -> PredictionBudget;

    /// Returns the valid count of the pattern nearest to `requested`.
    fn nearest_count(&self, pattern: &F, requested: usize) -> usize;

    /// Returns the predicted variance with `n_points`, a valid count.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`PredictorOn::predict`], and an error if the pattern does not support
    /// that number of points.
    fn predict_at(
        &mut self,
        pattern: &F,
        n_points: usize,
        budget: PredictionBudget,
        progress: &dyn Progress,
    ) -> Result<Self::Point, Error>;

    /// Returns whether the prediction with `n_points` is within the work of a budget.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict_at`] that occur without a realization.
    fn is_affordable_at(
        &mut self,
        pattern: &F,
        n_points: usize,
        budget: PredictionBudget,
    ) -> Result<bool, Error>;

    /// Returns whether [`Self::predict_at`] within a budget is known to return `point`, a prediction of
    /// this predictor within another budget, so that it need not be repeated. Default: false.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict_at`] that occur without a realization.
    fn is_repeated_by(
        &mut self,
        _pattern: &F,
        _point: &Self::Point,
        _budget: PredictionBudget,
    ) -> Result<bool, Error> {
        Ok(false)
    }

    /// Returns whether two realizations with `n_points` can differ by more than the randomization;
    /// `false` also where the pattern does not support that number.
    fn is_random_at(&self, pattern: &F, n_points: usize) -> bool;

    /// Returns whether a variance of at most `variance` with `n_points` is known to be impossible
    /// without a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn is_ruled_out(&mut self, pattern: &F, n_points: usize, variance: f64) -> Result<bool, Error>;
}

impl<F: SamplerFamily<S>, S: IntegrationSpace> CurvePredictor<F> for PredictorOn<'_, S> {
    type Point = PredictedPoint<S::Bands>;

    fn budget(&self) -> PredictionBudget {
        self.budget()
    }

    fn nearest_count(&self, pattern: &F, requested: usize) -> usize {
        pattern.nearest_count(requested, self.space())
    }

    fn predict_at(
        &mut self,
        pattern: &F,
        n_points: usize,
        budget: PredictionBudget,
        progress: &dyn Progress,
    ) -> Result<Self::Point, Error> {
        let sampler = build(pattern, n_points, self.space())?;
        self.predict_within(budget, S::sampler(&sampler), progress)
    }

    fn is_affordable_at(
        &mut self,
        pattern: &F,
        n_points: usize,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        let sampler = build(pattern, n_points, self.space())?;
        self.is_affordable_within(budget, S::sampler(&sampler))
    }

    fn is_repeated_by(
        &mut self,
        pattern: &F,
        point: &Self::Point,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        let sampler = build(pattern, point.n_points(), self.space())?;
        self.repeats(budget, S::sampler(&sampler), point)
    }

    fn is_random_at(&self, pattern: &F, n_points: usize) -> bool {
        let sampler = pattern.build(n_points, self.space());
        sampler.is_ok_and(|sampler| S::distribution(S::sampler(&sampler)).is_random())
    }

    /// White noise is never ruled out, since its predictions are nearly free.
    fn is_ruled_out(&mut self, pattern: &F, n_points: usize, variance: f64) -> Result<bool, Error> {
        let sampler = pattern.build(n_points, self.space());
        let kind = sampler
            .as_ref()
            .map_or(Distribution::Fixed, |sampler| S::distribution(S::sampler(sampler)));
        let white = self.white_variance(n_points);
        if matches!(kind, Distribution::Independent) || white <= variance {
            return Ok(false);
        }
        Ok(S::min_variance(self, n_points, kind.is_random())? > variance)
    }
}

/// Returns the sampler of `n_points` points. A family that builds another number of points causes
/// an error.
fn build<F: SamplerFamily<S>, S: IntegrationSpace>(
    pattern: &F,
    n_points: usize,
    space: S,
) -> Result<Box<S::Sampler>, Error> {
    let sampler = pattern.build(n_points, space)?;
    let got = S::n_points(S::sampler(&sampler));
    if got != n_points {
        let reason = format!("{pattern} was built with {got} points, not {n_points}");
        return Err(sphvar_samplers::Error::Given { reason }.into());
    }
    Ok(sampler)
}
