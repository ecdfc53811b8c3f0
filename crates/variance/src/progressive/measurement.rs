use std::ops::Range;

use rayon::prelude::{
    IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator, ParallelSliceMut,
};
use sphvar_samplers::{Ensemble, PointSet, Progress, Purpose};

use super::space::ProgressiveSpace;
use super::{ProgressivePoint, Randomized};
use crate::estimates::evaluation_work;
use crate::{Comparison, Error, Experiment, Measurement, PredictorOn, RelativeError};

/// The variance of the estimates of independent trials from the first points of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrefixMeasurement {
    /// The variance of the estimates. For sets as they are drawn, with a known integral, it is the
    /// mean squared deviation from the integral instead; see [`is_about_exact`](Self::is_about_exact).
    pub variance: f64,
    /// The standard error of the variance.
    pub stderr: f64,
    /// The end points of the 95 % confidence interval; `None` if too few trials decide about the
    /// variance, or if sets as they are drawn do not vary.
    pub interval: Option<(f64, f64)>,
    /// The difference of measured and predicted variance in standard errors,
    /// [`Comparison::z_score`](crate::Comparison::z_score); NaN without a prediction.
    pub z: f64,
    /// The mean estimate.
    pub mean: f64,
    /// The standard error of the mean.
    pub mean_stderr: f64,
    /// Mean minus exact integral in standard errors; NaN if the integral is unknown or too few
    /// trials hit the integrand.
    pub bias_z: f64,
    /// Whether the variance is the mean squared deviation from the exact integral.
    pub is_about_exact: bool,
    /// Whether too few trials hit the integrand's variation for an interval or a score.
    pub has_too_few_hits: bool,
    /// The number of trials.
    pub trials: u64,
}

/// The confidence of intervals.
const CONFIDENCE: f64 = 0.95;
/// The number of estimates that are kept in memory at a time, 512 MiB.
const MAX_ESTIMATES: usize = 1 << 26;

/// Trials of all prefixes of a sequence.
pub(super) struct PrefixTrials<'s, S: ProgressiveSpace> {
    pub(super) sampler: S::SamplerRef<'s>,
    pub(super) group: usize,
    pub(super) randomized: Randomized,
}

impl<S: ProgressiveSpace> PrefixTrials<'_, S> {
    /// Returns the points with variances measured from some trials.
    pub(super) fn measured(
        &self,
        predictor: &PredictorOn<'_, S>,
        points: Vec<ProgressivePoint>,
        trials: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<ProgressivePoint>, Error> {
        let mut measured = Vec::with_capacity(points.len());
        for points in points.chunks(prefixes_together(trials)) {
            let counts: Vec<usize> = points.iter().map(|point| point.n_points).collect();
            let rows = self.estimates(predictor, &counts, 0..trials, progress)?;
            let experiments = experiments(predictor, self.sampler, self.group, &counts)?;
            measured.extend(measured_points(
                points,
                &rows,
                &experiments,
                self.randomized,
                progress,
            )?);
        }
        Ok(measured)
    }

    /// Returns the estimates of some trials from the prefixes, trial by trial.
    pub(super) fn estimates(
        &self,
        predictor: &PredictorOn<'_, S>,
        counts: &[usize],
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let streams = predictor.streams(Purpose::Trial, self.group);
        let sets = match self.randomized {
            Randomized::Rotated => S::realizations(self.sampler, streams),
            Randomized::AsDrawn => S::as_drawn(self.sampler, streams),
        };
        let (integrand, area) = (predictor.integrand(), predictor.space().area());
        let last = counts.last().copied().unwrap_or(0);
        let first = trials.start;
        let trial = |(set, values): &mut (PointSet<S::Point>, Vec<f64>),
                     (index, row): (usize, &mut [f64])| {
            let index = first + index as u64;
            sets.realize_into(index, set, progress).map_err(sphvar_spectrum::Error::from)?;
            check_length(set.len(), last)?;
            set.points.truncate(last);
            set.weights.truncate(last);
            set.normalize_weights();
            values.clear();
            values.resize(set.len(), 0.0);
            S::eval_into(integrand, &set.points, values)?;
            progress.tick(evaluation_work(set.len()))?;
            prefix_means(set, values, counts, row);
            row.iter_mut().for_each(|mean| *mean *= area);
            Ok::<(), Error>(())
        };
        let count = trials.end.saturating_sub(first);
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let mut rows = vec![0.0; count.saturating_mul(counts.len())];
        rows.par_chunks_exact_mut(counts.len().max(1))
            .enumerate()
            .try_for_each_init(Default::default, trial)?;
        Ok(rows)
    }
}

/// Returns the number of prefixes whose estimates are kept in memory at a time. A block of prefixes
/// repeats the trials, so that memory is bounded.
pub(super) fn prefixes_together(trials: u64) -> usize {
    let trials = usize::try_from(trials).unwrap_or(usize::MAX);
    (MAX_ESTIMATES / trials.max(1)).max(1)
}

/// Returns what is known of the trials of each prefix of a sequence.
pub(super) fn experiments<S: ProgressiveSpace>(
    predictor: &PredictorOn<'_, S>,
    sampler: S::SamplerRef<'_>,
    group: usize,
    counts: &[usize],
) -> Result<Vec<Experiment>, Error> {
    let of_prefix = |&n_points: &usize| {
        S::with_prefix(sampler, n_points, group, |prefix| Ok(predictor.experiment(prefix)))
    };
    counts.iter().map(of_prefix).collect()
}

impl PrefixMeasurement {
    /// Returns the values of a comparison for the variance of trials.
    fn of(comparison: &Comparison, randomized: Randomized) -> Self {
        let Comparison { measurement, prediction, exact, .. } = comparison;
        let variance = measurement.variance();
        let own = Self {
            variance,
            stderr: variance * comparison.error().relative(),
            interval: comparison.measured_interval(CONFIDENCE),
            z: comparison.z_score(),
            mean: measurement.mean(),
            mean_stderr: measurement.mean_stderr(),
            bias_z: comparison.bias().map_or(f64::NAN, |test| test.z),
            is_about_exact: false,
            has_too_few_hits: comparison.has_too_few_hits(),
            trials: measurement.estimates().len() as u64,
        };
        let is_about_exact = randomized == Randomized::AsDrawn && prediction.is_unknown();
        match exact.filter(|_| is_about_exact) {
            Some(exact) => own.about(exact, comparison),
            None => own,
        }
    }

    /// Returns the measurement with the mean squared deviation from the exact integral.
    fn about(self, exact: f64, comparison: &Comparison) -> Self {
        let estimates = comparison.measurement.estimates();
        let squares = Measurement::new(estimates.iter().map(|x| (x - exact).powi(2)).collect());
        // Deviations that rounding alone can produce are none.
        let is_visible = squares.mean() > Comparison::BIAS_ROUNDING * comparison.rounding;
        let variance = if is_visible { squares.mean() } else { 0.0 };
        let own = Self { variance, is_about_exact: true, ..self };
        // The error of a set that does not vary is no estimate.
        if self.variance <= comparison.rounding {
            return Self { stderr: 0.0, interval: None, ..own };
        }
        let error = RelativeError::new(estimates.len(), squares.mean_stderr() / own.variance);
        Self {
            stderr: own.variance * error.relative(),
            interval: error.interval(own.variance, CONFIDENCE),
            ..own
        }
    }
}

/// Returns the points with the variances of estimates, which are given trial by trial.
pub(super) fn measured_points(
    points: &[ProgressivePoint],
    rows: &[f64],
    experiments: &[Experiment],
    randomized: Randomized,
    progress: &dyn Progress,
) -> Result<Vec<ProgressivePoint>, Error> {
    let of_prefix = |(i, (point, experiment)): (usize, (&ProgressivePoint, &Experiment))| {
        progress.tick(0.0)?;
        let estimates = rows.iter().skip(i).step_by(points.len()).copied().collect();
        let comparison = experiment.comparison(point.prediction, Measurement::new(estimates));
        let measurement = PrefixMeasurement::of(&comparison, randomized);
        Ok(ProgressivePoint { measurement: Some(measurement), ..point.clone() })
    };
    points.par_iter().zip(experiments).enumerate().map(of_prefix).collect()
}

/// Checks that a realization has the points of the longest prefix.
pub(super) fn check_length(n_points: usize, last: usize) -> Result<(), Error> {
    if n_points >= last {
        return Ok(());
    }
    let reason =
        format!("a realization has {n_points} points, fewer than the {last} of the longest prefix");
    Err(sphvar_samplers::Error::Given { reason }.into())
}

/// Writes the weighted means of the first values of a set.
fn prefix_means<P>(set: &PointSet<P>, values: &[f64], counts: &[usize], means: &mut [f64]) {
    let (mut sum, mut weights, mut next) = (0.0, 0.0, 0);
    for (mean, &count) in means.iter_mut().zip(counts) {
        for (k, value) in (next..).zip(&values[next..count]) {
            let weight = set.weights.get(k).copied().unwrap_or(1.0);
            sum += weight * value;
            weights += weight;
        }
        next = count;
        *mean = sum / weights;
    }
}
