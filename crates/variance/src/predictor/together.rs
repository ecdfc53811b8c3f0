//! Predictions for several integrands from the same spectra.

use sphvar_samplers::{PointSet, Progress, Purpose};
use sphvar_sh::Bands;
use sphvar_spectrum::{Accumulator, SpectrumAccumulator};

use super::PredictorOn;
use crate::route::Route;
use crate::space::IntegrationSpace;
use crate::{
    Error, PredictedPoint, Prediction, PredictionAccumulator, PredictionBudget,
    predict as predict_from,
};

/// The initial number of realizations of an estimate, if the budget allows it.
const FIRST: u64 = 8;

/// Returns the prediction of each predictor for a sampler. Predictors with spectra to the same
/// degree share them; predictions do not depend on the other predictors, which must have the same
/// seed, budget and options.
pub(crate) fn predict<S: IntegrationSpace>(
    predictors: &mut [&mut PredictorOn<'_, S>],
    budget: PredictionBudget,
    sampler: S::SamplerRef<'_>,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint<S::Bands>>, Error> {
    let extents =
        predictors.iter_mut().map(|p| p.extent(budget, sampler)).collect::<Result<Vec<_>, _>>()?;
    let mut points: Vec<Option<PredictedPoint<S::Bands>>> = vec![None; predictors.len()];
    for first in 0..predictors.len() {
        if points[first].is_some() {
            continue;
        }
        let extent = &extents[first];
        let members: Vec<usize> =
            (first..predictors.len()).filter(|&i| extents[i] == *extent).collect();
        let mut group: Vec<&mut PredictorOn<'_, S>> = Vec::new();
        for (i, predictor) in predictors.iter_mut().enumerate() {
            if members.contains(&i) {
                group.push(predictor);
            }
        }
        let found = to_extent(&mut group, budget, sampler, extent, progress)?;
        for ((i, predictor), mut point) in members.into_iter().zip(group).zip(found) {
            point.prediction.tail_error += S::hidden_tail(predictor, sampler, extent)?;
            if point.prediction.variance <= predictor.rounding() {
                let Prediction { variance, stderr, energy_stderr, .. } = &mut point.prediction;
                (*variance, *stderr) = (0.0, *energy_stderr);
            }
            points[i] = Some(point);
        }
    }
    Ok(points.into_iter().flatten().collect())
}

/// Returns the predictions from spectra to one extent.
fn to_extent<S: IntegrationSpace>(
    predictors: &mut [&mut PredictorOn<'_, S>],
    budget: PredictionBudget,
    sampler: S::SamplerRef<'_>,
    extent: &S::Extent,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint<S::Bands>>, Error> {
    let n_points = S::n_points(sampler);
    let Some(first) = predictors.first() else { return Ok(Vec::new()) };
    let (space, options) = (first.space, first.options);
    match Route::of::<S>(&options, budget, sampler, extent) {
        Route::Flat => {
            let spectrum = space.flat_spectrum(n_points, extent)?;
            let point = |p: &&mut PredictorOn<'_, S>| PredictedPoint {
                spectrum: spectrum.clone(),
                prediction: p.flat_prediction(n_points),
            };
            Ok(predictors.iter().map(point).collect())
        }
        Route::Exact(exact) => {
            let spectrum = S::exact_spectrum(&exact, extent, progress)?;
            let point = |p: &mut &mut PredictorOn<'_, S>| {
                let prediction = predict_from(&spectrum, p.energies_to(extent)?);
                Ok(PredictedPoint { spectrum: spectrum.clone(), prediction })
            };
            predictors.iter_mut().map(point).collect()
        }
        Route::All(sets) => {
            let empty = accumulators(predictors, n_points, extent)?;
            let all = 0..sets.len() as u64;
            exactly(&S::accumulate(&sets, &options, (n_points, extent), all, &empty, progress)?)
        }
        Route::Sampled if !S::distribution(sampler).is_random() => {
            let empty = accumulators(predictors, n_points, extent)?;
            let sets = predictors[0].realizations(Purpose::Pattern, sampler);
            exactly(&S::accumulate(&sets, &options, (n_points, extent), 0..1, &empty, progress)?)
        }
        Route::Sampled => estimate(predictors, budget, sampler, extent, progress),
    }
}

/// The sums over realizations: the spectrum, and the variance of each integrand.
pub(crate) type Sums<B> = (SpectrumAccumulator<B>, Vec<PredictionAccumulator<<B as Bands>::Tail>>);

fn accumulators<S: IntegrationSpace>(
    predictors: &mut [&mut PredictorOn<'_, S>],
    n_points: usize,
    extent: &S::Extent,
) -> Result<Sums<S::Bands>, Error> {
    let last = S::last_band(extent);
    let spectrum = predictors[0].space.empty_spectrum(n_points, extent)?;
    let each = predictors
        .iter_mut()
        .map(|p| Ok(PredictionAccumulator::new(p.energies_to(extent)?, n_points, last)));
    Ok((spectrum, each.collect::<Result<_, Error>>()?))
}

/// Returns the exact predictions from sums over all sets.
fn exactly<B: Bands>((spectrum, predictions): &Sums<B>) -> Result<Vec<PredictedPoint<B>>, Error> {
    let spectrum = spectrum.finish()?.into_exact();
    let point = |sum: &PredictionAccumulator<B::Tail>| {
        let prediction = sum.finish();
        let stderr = prediction.energy_stderr;
        let prediction = Prediction { stderr, dof: f64::INFINITY, ..prediction };
        PredictedPoint { spectrum: spectrum.clone(), prediction }
    };
    Ok(predictions.iter().map(point).collect())
}

/// Estimates the spectrum and the variances that it predicts from realizations. Each prediction
/// has the number of realizations that its own precision needs.
fn estimate<S: IntegrationSpace>(
    predictors: &mut [&mut PredictorOn<'_, S>],
    budget: PredictionBudget,
    sampler: S::SamplerRef<'_>,
    extent: &S::Extent,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint<S::Bands>>, Error> {
    let n_points = S::n_points(sampler);
    let empty = accumulators(predictors, n_points, extent)?;
    let Some(predictor) = predictors.first() else { return Ok(Vec::new()) };
    let max = predictor.max_realizations(budget, sampler, extent);
    let (options, size) = (predictor.options, (n_points, extent));
    let sets = predictor.realizations(Purpose::Pattern, sampler);
    let mut points: Vec<Option<PredictedPoint<S::Bands>>> = vec![None; predictors.len()];
    let (mut sum, mut count) = (empty.clone(), 0);
    let mut next = predictor.options.realizations.unwrap_or(FIRST.min(max));
    loop {
        sum.merge(&S::accumulate(&sets, &options, size, count..next, &empty, progress)?);
        count = next;
        for ((point, one), predictor) in points.iter_mut().zip(&sum.1).zip(&*predictors) {
            if point.is_some() {
                continue;
            }
            let prediction = one.finish();
            // A pattern without power where the integrand has energy leaves only rounding, with an
            // error of 100 %. More realizations do not reduce the errors of energies.
            let enough = one.spectrum_stderr() <= budget.relative * prediction.variance
                || prediction.variance <= predictor.rounding();
            if enough || count >= max {
                *point = Some(PredictedPoint { spectrum: sum.0.finish()?, prediction });
            }
        }
        if points.iter().all(Option::is_some) {
            return Ok(points.into_iter().flatten().collect());
        }
        next = (2 * count).min(max);
    }
}

/// Returns the mean prediction from sets, with the errors of tail and energies.
pub(crate) fn predict_from_sets<S: IntegrationSpace>(
    predictor: &mut PredictorOn<'_, S>,
    n_points: usize,
    extent: &S::Extent,
    sets: &[PointSet<S::Point>],
    progress: &dyn Progress,
) -> Result<Prediction, Error> {
    let empty = accumulators(&mut [predictor], n_points, extent)?;
    let (all, size) = (0..sets.len() as u64, (n_points, extent));
    let sums = S::accumulate(&sets, &predictor.options, size, all, &empty, progress)?;
    Ok(sums.1[0].finish())
}
