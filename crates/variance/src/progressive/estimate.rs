//! Predictions of all prefixes of a sequence from its realizations.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Ensemble, PointSet, Progress, Purpose};
use sphvar_spectrum::Moments;

use super::measurement::check_length;
use super::prefix::truncated;
use super::space::{PrefixVariances, ProgressiveSpace, is_void};
use super::{ProgressiveCurve, ProgressivePoint};
use crate::predictor::predict_from_sets;
use crate::space::Distribution;
use crate::{Error, Prediction, PredictionBudget, PredictorOn};

/// The work of the predictions of all prefixes, in units of that of a single prediction.
const CURVE_WORK: f64 = 8.0;
/// The initial number of realizations, if the budget allows it.
const FIRST: u64 = 8;
/// The maximum number of realizations whose variances are in memory at a time.
const BATCH: u64 = 256;
/// An error relative to the variance that rounding of the sums over points can produce.
const ROUNDING: f64 = 1e-12;
/// The maximum number of realizations whose spectra decide about the errors of tails.
const MAX_TRANSFORMED: usize = 8;

/// What determines the predictions of all prefixes of a sequence.
pub(super) struct PrefixEstimate<'s, S: ProgressiveSpace> {
    sampler: S::SamplerRef<'s>,
    group: usize,
    counts: Vec<usize>,
    variances: Arc<dyn PrefixVariances<S::Point>>,
    kind: Kind<'s, S::Point>,
}

/// Where the realizations come from.
enum Kind<'s, P> {
    /// One realization determines all.
    Fixed,
    /// All the given sets.
    All(&'s [PointSet<P>]),
    /// Up to a number of realizations.
    Sampled(u64),
}

/// The variances with some realizations.
pub(super) struct Drawn<P> {
    /// Of the variances and of their tails, for each number of points.
    moments: Vec<[Moments; 2]>,
    /// The first realizations.
    transformed: Vec<PointSet<P>>,
    count: u64,
}

/// The errors that the spectra of a prefix show.
#[derive(Clone, Copy, Debug)]
pub(super) struct Checkpoint {
    n_points: usize,
    /// The error of the tail relative to the tail.
    tail_error: f64,
    /// The error due to the energies relative to the variance.
    energy_error: f64,
}

impl<'s, S: ProgressiveSpace> PrefixEstimate<'s, S> {
    pub(super) fn new(
        predictor: &PredictorOn<'_, S>,
        sampler: S::SamplerRef<'s>,
        group: usize,
        counts: &[usize],
        variances: Arc<dyn PrefixVariances<S::Point>>,
    ) -> Self {
        let n_points = counts.last().copied().unwrap_or(0);
        let budget = predictor.budget();
        let budget = PredictionBudget { work: CURVE_WORK * budget.work, ..budget };
        let each = S::nominal_work(sampler).max(0.0) + variances.work(n_points);
        let requested = predictor.options().realizations;
        let max = requested.unwrap_or_else(|| budget.realizations_of(each));
        let kind = match S::distribution(sampler) {
            Distribution::OneOf(sets) if requested.is_none() && sets.len() as u64 <= max => {
                Kind::All(sets)
            }
            Distribution::Fixed => Kind::Fixed,
            _ => Kind::Sampled(max),
        };
        Self { sampler, group, counts: counts.to_vec(), variances, kind }
    }

    /// Returns the maximum nominal work of the predictions.
    pub(super) fn work(&self, predictor: &mut PredictorOn<'_, S>) -> Result<f64, Error> {
        let n_points = self.counts.last().copied().unwrap_or(0);
        let mut work = self.preparation_work() + self.work_of_realizations();
        if self.has_errors() {
            for n in checkpoints(n_points) {
                work += self.checkpoint_work(predictor, n)?;
            }
        }
        Ok(work)
    }

    /// Returns the maximum nominal work of all realizations.
    pub(super) fn work_of_realizations(&self) -> f64 {
        let n_points = self.counts.last().copied().unwrap_or(0);
        let realization = S::nominal_work(self.sampler).max(0.0);
        let sums = self.variances.work(n_points);
        let each = if matches!(self.kind, Kind::All(_)) { sums } else { realization + sums };
        self.max() as f64 * each
    }

    /// Returns the nominal work of the tables that all sets share.
    pub(super) fn preparation_work(&self) -> f64 {
        self.variances.preparation_work()
    }

    /// Returns the maximum nominal work of [`Self::checkpoint`].
    pub(super) fn checkpoint_work(
        &self,
        predictor: &mut PredictorOn<'_, S>,
        n_points: usize,
    ) -> Result<f64, Error> {
        let transformed = self.max().min(MAX_TRANSFORMED as u64) as f64;
        S::with_prefix(self.sampler, n_points, self.group, |prefix| {
            if is_void::<S>(prefix) {
                return Ok(0.0);
            }
            let extent = S::checkpoint_extent(predictor, prefix)?;
            Ok(transformed * S::ticked_work(predictor.options(), n_points, &extent))
        })
    }

    /// Returns the predictions.
    pub(super) fn curve(
        &self,
        predictor: &mut PredictorOn<'_, S>,
        progress: &dyn Progress,
    ) -> Result<ProgressiveCurve, Error> {
        let drawn = self.drawn(predictor, progress)?;
        let mut errors = Vec::new();
        if self.has_errors() {
            for n_points in checkpoints(self.counts.last().copied().unwrap_or(0)) {
                errors.extend(self.checkpoint(predictor, n_points, &drawn, progress)?);
            }
        }
        let hidden = self.hidden_tail(predictor)?;
        let points = self.points(predictor, &drawn, &errors, hidden);
        Ok(ProgressiveCurve { points, realizations: drawn.count })
    }

    /// Returns the variances of as many realizations as the budget requires.
    pub(super) fn drawn(
        &self,
        predictor: &PredictorOn<'_, S>,
        progress: &dyn Progress,
    ) -> Result<Drawn<S::Point>, Error> {
        self.variances.prepare(progress)?;
        let mut moments = vec![[Moments::default(), Moments::default()]; self.counts.len()];
        let mut transformed = Vec::new();
        let (mut count, max) = (0, self.max());
        let mut next =
            if predictor.options().realizations.is_some() { max } else { FIRST.min(max) };
        if !matches!(self.kind, Kind::Sampled(_)) {
            next = max;
        }
        loop {
            while count < next {
                let end = next.min(count + BATCH);
                for (set, variances) in self.of_realizations(predictor, count..end, progress)? {
                    for (moments, values) in moments.iter_mut().zip(variances) {
                        moments.iter_mut().zip(values).for_each(|(moments, x)| moments.push(x));
                    }
                    transformed.extend(set);
                }
                count = end;
            }
            let relative = predictor.budget().relative;
            let is_precise = |[variance, _]: &[Moments; 2]| {
                let mean = variance.mean();
                // A variance that is unknown or mere rounding has no precision.
                let has_none = mean.is_nan() || mean <= predictor.rounding();
                has_none || variance.standard_error() <= relative * mean
            };
            if count >= max || moments.iter().all(is_precise) {
                break;
            }
            next = (2 * count).min(max);
        }
        Ok(Drawn { moments, transformed, count })
    }

    /// Returns the predictions from realizations, the errors of some numbers of points and the part
    /// of [`Self::hidden_tail`].
    pub(super) fn points(
        &self,
        predictor: &PredictorOn<'_, S>,
        drawn: &Drawn<S::Point>,
        errors: &[Checkpoint],
        hidden: f64,
    ) -> Vec<ProgressivePoint> {
        let point = |(&n_points, moments): (&usize, &[Moments; 2])| {
            let hidden = hidden / n_points as f64;
            let prediction = self.prediction(predictor, moments, at(errors, n_points), hidden);
            ProgressivePoint { n_points, prediction, measurement: None }
        };
        self.counts.iter().zip(&drawn.moments).map(point).collect()
    }

    /// Returns the maximum number of realizations.
    pub(super) fn max(&self) -> u64 {
        match &self.kind {
            Kind::Fixed => 1,
            Kind::All(sets) => sets.len() as u64,
            Kind::Sampled(max) => *max,
        }
    }

    /// Returns the variances with each realization, beside the first sets.
    #[expect(clippy::type_complexity, reason = "an intermediate result")]
    fn of_realizations(
        &self,
        predictor: &PredictorOn<'_, S>,
        range: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<(Option<PointSet<S::Point>>, Vec<[f64; 2]>)>, Error> {
        let streams = predictor.streams(Purpose::Pattern, self.group);
        let drawn = S::realizations(self.sampler, streams);
        let given = match &self.kind {
            Kind::All(sets) => Some(*sets),
            _ => None,
        };
        let sets: &dyn Ensemble<S::Point> = match &given {
            Some(sets) => sets,
            None => &drawn,
        };
        let (counts, variances) = (&*self.counts, &*self.variances);
        let last = counts.last().copied().unwrap_or(0);
        let of_one = |index: u64| {
            let mut set = PointSet::default();
            sets.realize_into(index, &mut set, progress).map_err(sphvar_spectrum::Error::from)?;
            check_length(set.len(), last)?;
            let found = variances.of_set(&set, counts, progress)?;
            Ok(((index < MAX_TRANSFORMED as u64).then_some(set), found))
        };
        range.into_par_iter().map(of_one).collect()
    }

    /// Returns whether the predictions have errors that the sums of prefixes do not show.
    pub(super) fn has_errors(&self) -> bool {
        self.variances.has_tail() || self.variances.has_estimates()
    }

    /// Returns the errors of the prefix with `n_points` points by the rules of single predictions;
    /// `None` if it estimates nothing.
    pub(super) fn checkpoint(
        &self,
        predictor: &mut PredictorOn<'_, S>,
        n_points: usize,
        drawn: &Drawn<S::Point>,
        progress: &dyn Progress,
    ) -> Result<Option<Checkpoint>, Error> {
        let sets = truncated(&drawn.transformed, n_points);
        if sets.iter().any(|set| set.n_effective() <= 0.0) {
            return Ok(None);
        }
        let extent = S::with_prefix(self.sampler, n_points, self.group, |prefix| {
            S::checkpoint_extent(predictor, prefix)
        })?;
        let of = predict_from_sets(predictor, n_points, &extent, &sets, progress)?;
        let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        Ok(Some(Checkpoint {
            n_points,
            tail_error: ratio(of.tail_error, of.tail),
            energy_error: ratio(of.energy_stderr, of.variance),
        }))
    }

    /// Returns the part of the variance that rounding of the energies hides, times the number of
    /// points.
    pub(super) fn hidden_tail(&self, predictor: &mut PredictorOn<'_, S>) -> Result<f64, Error> {
        let n_points = self.counts.last().copied().unwrap_or(0);
        S::with_prefix(self.sampler, n_points, self.group, |prefix| {
            if is_void::<S>(prefix) {
                return Ok(0.0);
            }
            let extent = S::checkpoint_extent(predictor, prefix)?;
            Ok(S::hidden_tail(predictor, prefix, &extent)? * n_points as f64)
        })
    }

    fn prediction(
        &self,
        predictor: &PredictorOn<'_, S>,
        [variance, tail]: &[Moments; 2],
        errors: [f64; 2],
        hidden: f64,
    ) -> Prediction {
        let (is_random, mean) = (matches!(self.kind, Kind::Sampled(_)), variance.mean());
        if mean.is_nan() {
            return Prediction::UNKNOWN;
        }
        let is_visible = mean > predictor.rounding();
        let spectral = if is_random { variance.standard_error() } else { 0.0 };
        // Realizations with the same variance differ by rounding.
        let visible = |error: f64| if error <= ROUNDING * mean { 0.0 } else { error };
        Prediction {
            variance: if is_visible { mean } else { 0.0 },
            stderr: if is_visible { visible(spectral) } else { 0.0 },
            energy_stderr: 0.0,
            tail: tail.mean(),
            tail_error: visible(errors[0] * tail.mean() + hidden),
            dof: if is_random { variance.count().saturating_sub(1) as f64 } else { f64::INFINITY },
        }
        .with_energy_stderr(visible(errors[1] * mean))
    }
}

/// Returns the powers of two up to `n_points`, and that number.
fn checkpoints(n_points: usize) -> impl Iterator<Item = usize> {
    let powers = (0..usize::BITS).map(|k| 1 << k).take_while(move |n| *n < n_points);
    powers.chain((n_points > 0).then_some(n_points))
}

/// Returns the errors of tail and energies at a number of points: the larger ones of the two
/// neighbouring checkpoints.
fn at(checkpoints: &[Checkpoint], n_points: usize) -> [f64; 2] {
    let above = checkpoints.partition_point(|c| c.n_points < n_points);
    let is_there = checkpoints.get(above).is_some_and(|c| c.n_points == n_points);
    let first = if is_there { above } else { above.saturating_sub(1) };
    let neighbours = &checkpoints[first..(above + 1).min(checkpoints.len())];
    neighbours.iter().fold([0.0, 0.0], |[tail, energy], c| {
        [f64::max(tail, c.tail_error), f64::max(energy, c.energy_error)]
    })
}
