//! Predictions of whole sets, made for each number of points, by the sums over points of prefixes.

use sphvar_samplers::Progress;

use super::ProgressivePoint;
use super::estimate::PrefixEstimate;
use super::prefixes::Prefixes;
use super::space::ProgressiveSpace;
use crate::Error;

impl<S: ProgressiveSpace> Prefixes<'_, '_, S> {
    /// Returns the predictions of
    /// [`ProgressivePredictor::predict_sets`](super::ProgressivePredictor::predict_sets).
    pub(super) fn of_sets(
        &mut self,
        samplers: &[S::SamplerRef<'_>],
        progress: &dyn Progress,
    ) -> Result<Vec<ProgressivePoint>, Error> {
        let estimates = self.estimates(samplers)?;
        let Some(last) = estimates.last() else { return Ok(Vec::new()) };
        let predictor = &*self.predictor;
        let drawn = estimates.iter().map(|estimate| estimate.drawn(predictor, progress));
        let drawn = drawn.collect::<Result<Vec<_>, Error>>()?;
        let mut errors = Vec::new();
        if last.has_errors() {
            for k in checkpoints::<S>(samplers) {
                let n_points = S::n_points(samplers[k]);
                errors.extend(estimates[k].checkpoint(
                    self.predictor,
                    n_points,
                    &drawn[k],
                    progress,
                )?);
            }
        }
        let hidden = last.hidden_tail(self.predictor)?;
        let both = estimates.iter().zip(&drawn);
        Ok(both.flat_map(|(e, drawn)| e.points(self.predictor, drawn, &errors, hidden)).collect())
    }

    /// Returns the maximum nominal work of [`Self::of_sets`].
    pub(super) fn work_of_sets(&mut self, samplers: &[S::SamplerRef<'_>]) -> Result<f64, Error> {
        let estimates = self.estimates(samplers)?;
        let mut work: f64 = estimates.iter().map(PrefixEstimate::work_of_realizations).sum();
        if let Some(last) = estimates.last() {
            work += last.preparation_work();
            if last.has_errors() {
                for k in checkpoints::<S>(samplers) {
                    work +=
                        estimates[k].checkpoint_work(self.predictor, S::n_points(samplers[k]))?;
                }
            }
        }
        Ok(work)
    }

    /// Returns the estimates of the sets, which share the tables of the largest one.
    fn estimates<'s>(
        &mut self,
        samplers: &[S::SamplerRef<'s>],
    ) -> Result<Vec<PrefixEstimate<'s, S>>, Error> {
        let Some(&largest) = samplers.last() else { return Ok(Vec::new()) };
        let variances =
            self.variances(largest, S::stream_group(largest), &[S::n_points(largest)])?;
        let estimate = |&sampler: &S::SamplerRef<'s>| {
            let (group, counts) = (S::stream_group(sampler), [S::n_points(sampler)]);
            PrefixEstimate::new(self.predictor, sampler, group, &counts, variances.clone())
        };
        Ok(samplers.iter().map(estimate).collect())
    }
}

/// Returns the places of the first samplers with at least each power of two points, and of the last
/// one.
fn checkpoints<S: ProgressiveSpace>(samplers: &[S::SamplerRef<'_>]) -> Vec<usize> {
    let power = |k: usize| S::n_points(samplers[k]).next_power_of_two();
    let is_first = |k: &usize| {
        let k = *k;
        k == 0
            || k + 1 == samplers.len()
            || S::n_points(samplers[k]) == power(k)
            || power(k - 1) < S::n_points(samplers[k])
    };
    (0..samplers.len()).filter(is_first).collect()
}
