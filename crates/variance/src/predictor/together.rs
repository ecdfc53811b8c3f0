//! Predictions for several integrands from the same spectra.

use sphvar_samplers::{Progress, Sampler};
use sphvar_sh::{LmIndex, MAX_DEGREE};
use sphvar_spectrum::{Accumulator, Spectrum, SpectrumAccumulator, accumulate};

use super::Predictor;
use crate::route::Route;
use crate::{
    Error, PredictedPoint, Prediction, PredictionAccumulator, PredictionBudget,
    predict as predict_from,
};

/// The initial number of realizations of an estimate, if the budget allows it.
const FIRST: u64 = 8;

/// Returns the prediction of each predictor for a sampler. Predictors with spectra to the same
/// degree share them; predictions do not depend on the other predictors, which must have the same
/// seed, budget and options.
pub(crate) fn predict(
    predictors: &mut [&mut Predictor<'_>],
    budget: PredictionBudget,
    sampler: &dyn Sampler,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint>, Error> {
    let degrees =
        predictors.iter_mut().map(|p| p.degree(budget, sampler)).collect::<Result<Vec<_>, _>>()?;
    let mut points: Vec<Option<PredictedPoint>> = vec![None; predictors.len()];
    for first in 0..predictors.len() {
        if points[first].is_some() {
            continue;
        }
        let lmax = degrees[first];
        let members: Vec<usize> =
            (first..predictors.len()).filter(|&i| degrees[i] == lmax).collect();
        let mut group: Vec<&mut Predictor<'_>> = Vec::new();
        for (i, predictor) in predictors.iter_mut().enumerate() {
            if members.contains(&i) {
                group.push(predictor);
            }
        }
        let found = of_degree(&mut group, budget, sampler, lmax, progress)?;
        for ((i, predictor), mut point) in members.into_iter().zip(group).zip(found) {
            if point.prediction.variance <= predictor.rounding() {
                let Prediction { variance, stderr, energy_stderr, .. } = &mut point.prediction;
                (*variance, *stderr) = (0.0, *energy_stderr);
            }
            points[i] = Some(point);
        }
    }
    Ok(points.into_iter().flatten().collect())
}

/// Returns the predictions from spectra to degree `lmax`.
fn of_degree(
    predictors: &mut [&mut Predictor<'_>],
    budget: PredictionBudget,
    sampler: &dyn Sampler,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint>, Error> {
    let n_points = sampler.n_points();
    let Some(first) = predictors.first() else { return Ok(Vec::new()) };
    let (domain, resolution) = (first.domain, first.resolution(lmax, n_points));
    match Route::of(&first.options, budget, sampler, lmax) {
        Route::Flat => {
            let power = vec![1.0; lmax.min(MAX_DEGREE) + 1];
            let spectrum = Spectrum::exact(domain, n_points, power);
            let point = |p: &&mut Predictor<'_>| PredictedPoint {
                spectrum: spectrum.clone(),
                prediction: p.flat_prediction(n_points),
            };
            Ok(predictors.iter().map(point).collect())
        }
        Route::Exact(exact) => {
            let spectrum = exact.to(lmax, progress)?;
            let point = |p: &mut &mut Predictor<'_>| {
                let prediction = predict_from(&spectrum, p.energy_to(lmax)?);
                Ok(PredictedPoint { spectrum: spectrum.clone(), prediction })
            };
            predictors.iter_mut().map(point).collect()
        }
        Route::All(sets) => {
            let empty = accumulators(predictors, sampler, lmax)?;
            let all = 0..sets.len() as u64;
            exactly(&accumulate(&sets, resolution, all, &empty, progress)?)
        }
        Route::Sampled if !sampler.is_random() => {
            let empty = accumulators(predictors, sampler, lmax)?;
            let sets = predictors[0].realizations(sampler);
            exactly(&accumulate(&sets, resolution, 0..1, &empty, progress)?)
        }
        Route::Sampled => estimate(predictors, budget, sampler, lmax, progress),
    }
}

/// The sums over realizations: the spectrum, and the variance of each integrand.
type Sums = (SpectrumAccumulator, Vec<PredictionAccumulator>);

fn accumulators(
    predictors: &mut [&mut Predictor<'_>],
    sampler: &dyn Sampler,
    lmax: usize,
) -> Result<Sums, Error> {
    let n_points = sampler.n_points();
    // Degrees for which no transform exists need no memory either.
    LmIndex::new(lmax).map_err(sphvar_spectrum::Error::from)?;
    let spectrum = SpectrumAccumulator::new(sampler.domain(), n_points, lmax);
    let each = predictors
        .iter_mut()
        .map(|p| Ok(PredictionAccumulator::new(p.energy_to(lmax)?, n_points, lmax)));
    Ok((spectrum, each.collect::<Result<_, Error>>()?))
}

/// Returns the exact predictions from sums over all sets.
fn exactly((spectrum, predictions): &Sums) -> Result<Vec<PredictedPoint>, Error> {
    let spectrum = spectrum.finish()?.into_exact();
    let point = |sum: &PredictionAccumulator| {
        let prediction = sum.finish();
        let stderr = prediction.energy_stderr;
        let prediction = Prediction { stderr, dof: f64::INFINITY, ..prediction };
        PredictedPoint { spectrum: spectrum.clone(), prediction }
    };
    Ok(predictions.iter().map(point).collect())
}

/// Estimates the spectrum and the variances that it predicts from realizations. Each prediction
/// has the number of realizations that its own precision needs.
fn estimate(
    predictors: &mut [&mut Predictor<'_>],
    budget: PredictionBudget,
    sampler: &dyn Sampler,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Vec<PredictedPoint>, Error> {
    let empty = accumulators(predictors, sampler, lmax)?;
    let Some(predictor) = predictors.first() else { return Ok(Vec::new()) };
    let max = predictor.max_realizations(budget, sampler, lmax);
    let resolution = predictor.resolution(lmax, sampler.n_points());
    let sets = predictor.realizations(sampler);
    let mut points: Vec<Option<PredictedPoint>> = vec![None; predictors.len()];
    let (mut sum, mut count) = (empty.clone(), 0);
    let mut next = predictor.options.realizations.unwrap_or(FIRST.min(max));
    loop {
        sum.merge(&accumulate(&sets, resolution, count..next, &empty, progress)?);
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
