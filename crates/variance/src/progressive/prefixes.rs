//! How prefixes are predicted.

use std::sync::Arc;

use sphvar_samplers::Progress;

use super::estimate::PrefixEstimate;
use super::space::{PrefixVariances, ProgressiveSpace, is_homogeneous, is_void};
use super::{ProgressiveCurve, ProgressivePoint};
use crate::{Error, Prediction, PredictionBudget, PredictorOn};

/// The variances of prefixes of any sets of up to a number of points, once they have been prepared.
pub(super) type KnownVariances<P> = Option<(usize, Arc<dyn PrefixVariances<P>>)>;

/// Predicts prefixes of sequences with a predictor of single sets.
pub(super) struct Prefixes<'p, 'a, S: ProgressiveSpace> {
    pub(super) predictor: &'p mut PredictorOn<'a, S>,
    pub(super) known: &'p mut KnownVariances<S::Point>,
}

/// A method of prediction.
enum Route<'s, S: ProgressiveSpace> {
    /// In closed form.
    Flat,
    /// All together, from sums over their points.
    Together(PrefixEstimate<'s, S>),
    /// Each from its own spectrum, within a budget.
    Single(PredictionBudget),
}

impl<S: ProgressiveSpace> Prefixes<'_, '_, S> {
    /// Returns the predictions of [`ProgressivePredictor`](super::ProgressivePredictor).
    pub(super) fn predict(
        &mut self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        check_counts(counts, S::n_points(sampler))?;
        let mut curve = match self.route(sampler, group, counts)? {
            Route::Flat => return Ok(self.flat(counts)),
            Route::Together(estimate) => estimate.curve(self.predictor, progress),
            Route::Single(budget) => self.singly(sampler, (group, counts), budget, progress),
        }?;
        // A single rotated or shifted point is uniform.
        let options = self.predictor.options();
        let is_left_open = options.realizations.is_none() && options.lmax.is_none();
        if let Some(first) = curve.points.first_mut()
            && (first.n_points, is_left_open) == (1, true)
            && !first.prediction.is_unknown()
        {
            first.prediction = self.predictor.flat_prediction(1);
        }
        Ok(curve)
    }

    /// Returns the maximum nominal work of the predictions.
    pub(super) fn work(
        &mut self,
        sampler: S::SamplerRef<'_>,
        counts: &[usize],
    ) -> Result<f64, Error> {
        match self.route(sampler, 0, counts)? {
            Route::Flat => Ok(0.0),
            Route::Together(estimate) => estimate.work(self.predictor),
            Route::Single(budget) => self.sum(sampler, (0, counts), |predictor, prefix| {
                predictor.work_within(budget, prefix)
            }),
        }
    }

    /// Returns the sum of the work of the prefixes that estimate something.
    fn sum(
        &mut self,
        sampler: S::SamplerRef<'_>,
        (group, counts): (usize, &[usize]),
        work: impl Fn(&mut PredictorOn<'_, S>, S::SamplerRef<'_>) -> Result<f64, Error>,
    ) -> Result<f64, Error> {
        let of_prefix = |&n_points: &usize| {
            S::with_prefix(sampler, n_points, group, |prefix| {
                if is_void::<S>(prefix) { Ok(0.0) } else { work(self.predictor, prefix) }
            })
        };
        counts.iter().map(of_prefix).sum()
    }

    /// Chooses how prefixes are predicted: by the method that takes less work in total for the same
    /// number of realizations. Single predictions stop when each is precise, but within a budget of
    /// their own, so that those of many prefixes can take far more work than the sums for all; their
    /// budgets are then reduced to the work of these.
    fn route<'s>(
        &mut self,
        sampler: S::SamplerRef<'s>,
        group: usize,
        counts: &[usize],
    ) -> Result<Route<'s, S>, Error> {
        let is_left_open = self.predictor.options().realizations.is_none();
        if is_left_open && is_homogeneous::<S>(sampler) {
            return Ok(Route::Flat);
        }
        let variances = self.variances(sampler, group, counts)?;
        let estimate = PrefixEstimate::new(self.predictor, sampler, group, counts, variances);
        let (together, realizations) = (estimate.work(self.predictor)?, estimate.max());
        let mut of_spectra = 0.0;
        for count in counts {
            of_spectra +=
                self.sum(sampler, (group, std::slice::from_ref(count)), |predictor, prefix| {
                    predictor.work_of_realizations(prefix, realizations)
                })?;
            if of_spectra >= together {
                return Ok(Route::Together(estimate));
            }
        }
        let budget = self.predictor.budget();
        let singly = self.sum(sampler, (group, counts), |predictor, prefix| {
            predictor.work_within(budget, prefix)
        })?;
        let is_reduced = is_left_open && singly > together;
        let share = if is_reduced { together / singly } else { 1.0 };
        Ok(Route::Single(PredictionBudget { work: share * budget.work, ..budget }))
    }

    /// Returns the sums over the points of sets up to the last count, which do not depend on the
    /// sampler otherwise.
    pub(super) fn variances(
        &mut self,
        sampler: S::SamplerRef<'_>,
        group: usize,
        counts: &[usize],
    ) -> Result<Arc<dyn PrefixVariances<S::Point>>, Error> {
        let n_points = counts.last().copied().unwrap_or(1);
        if let Some((_, known)) = self.known.as_ref().filter(|(n, _)| *n == n_points) {
            return Ok(known.clone());
        }
        let predictor = &mut *self.predictor;
        let found = S::with_prefix(sampler, n_points, group, |prefix| {
            S::prefix_variances(predictor, prefix)
        })?;
        let found: Arc<dyn PrefixVariances<S::Point>> = found.into();
        *self.known = Some((n_points, found.clone()));
        Ok(found)
    }

    /// Returns the predictions of independent points.
    fn flat(&self, counts: &[usize]) -> ProgressiveCurve {
        let point = |&n_points: &usize| ProgressivePoint {
            n_points,
            prediction: self.predictor.flat_prediction(n_points),
            measurement: None,
        };
        ProgressiveCurve { points: counts.iter().map(point).collect(), realizations: 0 }
    }

    /// Returns the prediction of each prefix from its own spectrum.
    fn singly(
        &mut self,
        sampler: S::SamplerRef<'_>,
        (group, counts): (usize, &[usize]),
        budget: PredictionBudget,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        let mut realizations = 0;
        let mut predict = |&n_points: &usize| {
            let prediction = S::with_prefix(sampler, n_points, group, |prefix| {
                if is_void::<S>(prefix) {
                    return Ok(Prediction::UNKNOWN);
                }
                let point = self.predictor.predict_within(budget, prefix, progress)?;
                realizations = realizations.max(point.spectrum.realizations());
                Ok(point.prediction)
            })?;
            Ok(ProgressivePoint { n_points, prediction, measurement: None })
        };
        let points = counts.iter().map(&mut predict).collect::<Result<_, Error>>()?;
        Ok(ProgressiveCurve { points, realizations })
    }
}

/// Returns the curve without predictions.
pub(super) fn unknown(counts: &[usize]) -> ProgressiveCurve {
    let point = |&n_points: &usize| ProgressivePoint {
        n_points,
        prediction: Prediction::UNKNOWN,
        measurement: None,
    };
    ProgressiveCurve { points: counts.iter().map(point).collect(), realizations: 0 }
}

/// Checks that numbers of points are distinct, increasing and those of prefixes.
pub(super) fn check_counts(counts: &[usize], n_points: usize) -> Result<(), Error> {
    let is_increasing = counts.windows(2).all(|pair| pair[0] < pair[1]);
    let out_of_range = counts.iter().find(|&&n| n == 0 || n > n_points || !is_increasing);
    match out_of_range {
        None => Ok(()),
        Some(&n) => {
            let range = "increasing, from 1 to the number of points of the sequence";
            Err(Error::Parameter { name: "numbers of points", range, got: n as f64 })
        }
    }
}
