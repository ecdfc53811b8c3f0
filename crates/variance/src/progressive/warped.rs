//! Prefixes of warped sequences.

use sphvar_samplers::{Progress, Square};

use super::measurement::{PrefixTrials, experiments as known_trials, measured_points};
use super::prefixes::{Prefixes, check_counts, unknown};
use super::space::is_homogeneous;
use super::{ProgressiveCurve, Randomized};
use crate::warped::sum;
use crate::{Error, Experiment, WarpedPattern, WarpedPredictor};

impl WarpedPredictor<'_> {
    /// Returns the predicted variances of the first points of a warped sequence, where they are
    /// known, and the measured ones, unless `trials` is 0.
    ///
    /// `counts` are distinct total numbers of points in increasing order, all of them valid
    /// ([`WarpedPattern::nearest_count`]). Of several strategies, a prefix has the first points of
    /// each, in the numbers of [`WarpedPattern::counts`], which never decrease. `group` is the number of
    /// the random streams of the sequence. The estimate and its variances are those of
    /// [`ProgressivePredictor`](crate::ProgressivePredictor) for the strategies, added.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`WarpedPattern::samplers`],
    /// [`ProgressivePredictor::curve`](crate::ProgressivePredictor::curve) and
    /// [`Error::Strategies`].
    pub fn progressive(
        &mut self,
        pattern: &WarpedPattern,
        group: usize,
        counts: &[usize],
        trials: u64,
        randomized: Randomized,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        let Some(&last) = counts.last() else { return Ok(unknown(counts)) };
        let samplers = self.samplers(pattern, last)?;
        check_counts(counts, last)?;
        for &n in counts {
            if pattern.nearest_count(n) != n {
                self.samplers(pattern, n)?;
            }
        }
        let parts: Vec<Vec<usize>> = counts.iter().map(|&n| pattern.counts(n)).collect();
        let of_strategy = |i: usize| parts.iter().map(|part| part[i]).collect::<Vec<usize>>();
        let are_homogeneous = samplers.iter().all(|sampler| is_homogeneous::<Square>(&**sampler));
        let is_predicted = randomized == Randomized::Rotated || are_homogeneous;
        let mut curve = unknown(counts);
        if is_predicted {
            let mut predictions = vec![Vec::new(); counts.len()];
            for (i, (predictor, sampler)) in self.predictors().zip(&samplers).enumerate() {
                let own = of_strategy(i);
                let mut distinct = own.clone();
                distinct.dedup();
                let mut prefixes = Prefixes { predictor, known: &mut None };
                let found = prefixes.predict(&**sampler, group, &distinct, progress)?;
                curve.realizations = curve.realizations.max(found.realizations);
                for (all, n) in predictions.iter_mut().zip(own) {
                    let at = found.points.partition_point(|point| point.n_points < n);
                    all.push(found.points[at].prediction);
                }
            }
            for (point, predictions) in curve.points.iter_mut().zip(&predictions) {
                point.prediction = sum(predictions);
            }
        }
        if trials == 0 {
            return Ok(curve);
        }
        let integral = self.integral();
        let mut rows: Vec<f64> = Vec::new();
        let mut experiments = vec![Vec::new(); counts.len()];
        for (i, (predictor, sampler)) in self.predictors().zip(&samplers).enumerate() {
            let own = of_strategy(i);
            let of = PrefixTrials::<Square> { sampler: &**sampler, group, randomized };
            let estimates = of.estimates(predictor, &own, 0..trials, progress)?;
            if i == 0 {
                rows = estimates;
            } else {
                rows.iter_mut().zip(estimates).for_each(|(sum, estimate)| *sum += estimate);
            }
            let known = known_trials(predictor, &**sampler, group, &own)?;
            for (all, experiment) in experiments.iter_mut().zip(known) {
                all.push(experiment);
            }
        }
        let experiments: Vec<Experiment> =
            experiments.iter().map(|parts| Experiment::of_sum(parts, integral)).collect();
        let points = measured_points(&curve.points, &rows, &experiments, randomized, progress)?;
        Ok(ProgressiveCurve { points, ..curve })
    }
}
