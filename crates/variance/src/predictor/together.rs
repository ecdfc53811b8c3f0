//! Predictions for several integrands from the same spectra.

use std::ops::Range;

use sphvar_samplers::{Domain, PointSet, Progress, Purpose, Sampler};
use sphvar_sh::{Bands, ByParity};
use sphvar_spectrum::{Accumulator, Spectrum, SpectrumAccumulator};

use super::{Predictor, PredictorOn};
use crate::prediction::PredictionMoments;
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
    let extents = extents(predictors, budget, sampler)?;
    let mut points: Vec<Option<PredictedPoint<S::Bands>>> = vec![None; predictors.len()];
    for members in groups(&extents) {
        let extent = &extents[members[0]];
        let mut group = select(predictors, &members);
        let found = to_extent(&mut group, budget, sampler, extent, progress)?;
        place(&mut points, &members, group, found, (sampler, extent))?;
    }
    Ok(points.into_iter().flatten().collect())
}

/// Returns how far the spectrum of each predictor is computed.
fn extents<S: IntegrationSpace>(
    predictors: &mut [&mut PredictorOn<'_, S>],
    budget: PredictionBudget,
    sampler: S::SamplerRef<'_>,
) -> Result<Vec<S::Extent>, Error> {
    predictors.iter_mut().map(|p| p.extent(budget, sampler)).collect()
}

/// Returns the numbers of the predictors with equal extents, none of which is empty.
fn groups<E: PartialEq>(extents: &[E]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (i, extent) in extents.iter().enumerate() {
        match groups.iter_mut().find(|group| extents[group[0]] == *extent) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    groups
}

/// Returns the predictors with these numbers.
fn select<'p, 'a, S: IntegrationSpace>(
    predictors: &'p mut [&mut PredictorOn<'a, S>],
    members: &[usize],
) -> Vec<&'p mut PredictorOn<'a, S>> {
    let numbered = predictors.iter_mut().enumerate();
    numbered.filter(|(i, _)| members.contains(i)).map(|(_, predictor)| &mut **predictor).collect()
}

/// Puts the predictions of a group in their places, with the parts of the error that spectra do not
/// show.
fn place<S: IntegrationSpace>(
    points: &mut [Option<PredictedPoint<S::Bands>>],
    members: &[usize],
    group: Vec<&mut PredictorOn<'_, S>>,
    found: Vec<PredictedPoint<S::Bands>>,
    (sampler, extent): (S::SamplerRef<'_>, &S::Extent),
) -> Result<(), Error> {
    for ((&i, predictor), mut point) in members.iter().zip(group).zip(found) {
        point.prediction.tail_error += S::hidden_tail(predictor, sampler, extent)?;
        if point.prediction.variance <= predictor.rounding() {
            let Prediction { variance, stderr, energy_stderr, .. } = &mut point.prediction;
            (*variance, *stderr) = (0.0, *energy_stderr);
        }
        points[i] = Some(point);
    }
    Ok(())
}

/// Sums over realizations of a sampler from which predictions follow: of the spectra to each degree,
/// and of the variances of the integrands with this degree.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PredictionSums {
    groups: Vec<(SpectrumAccumulator, Vec<PredictionMoments<ByParity>>)>,
}

impl PredictionSums {
    /// Adds the realizations of other sums for the same sampler and integrands exactly.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Spectrum`] if the sums are of other spectra.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        let counts =
            |sums: &Self| sums.groups.iter().map(|group| group.1.len()).collect::<Vec<_>>();
        let (left, right) = (counts(self), counts(other));
        if left != right {
            let what = "numbers of integrands";
            let [left, right] = [left, right].map(|counts| format!("{counts:?}"));
            return Err(sphvar_spectrum::Error::Mismatch { what, left, right }.into());
        }
        for (mine, theirs) in self.groups.iter_mut().zip(&other.groups) {
            mine.0.try_merge(&theirs.0)?;
            mine.1.iter_mut().zip(&theirs.1).for_each(|(mine, theirs)| mine.merge(theirs));
        }
        Ok(())
    }
}

/// Returns the sums over some realizations.
pub(crate) fn sums(
    predictors: &mut [&mut Predictor<'_>],
    budget: PredictionBudget,
    sampler: &dyn Sampler,
    realizations: Range<u64>,
    progress: &dyn Progress,
) -> Result<PredictionSums, Error> {
    let extents = extents(predictors, budget, sampler)?;
    let n_points = sampler.n_points();
    let mut sums = Vec::new();
    for members in groups(&extents) {
        let extent = &extents[members[0]];
        let mut group = select(predictors, &members);
        let empty = accumulators(&mut group, n_points, extent)?;
        let Some(first) = group.first() else { continue };
        let sets = first.realizations(Purpose::Pattern, sampler);
        let (workspaces, options, size) = (&first.workspaces, &first.options, (n_points, extent));
        let range = realizations.clone();
        let (spectrum, predictions) =
            Domain::accumulate(workspaces, &sets, options, size, range, &empty, progress)?;
        let moments = predictions.into_iter().map(PredictionAccumulator::into_sums);
        sums.push((spectrum, moments.collect()));
    }
    Ok(PredictionSums { groups: sums })
}

/// Returns the predictions from sums, those of [`predict`] for as many realizations.
pub(crate) fn predict_from_sums(
    predictors: &mut [&mut Predictor<'_>],
    budget: PredictionBudget,
    sampler: &dyn Sampler,
    sums: &PredictionSums,
) -> Result<Vec<PredictedPoint>, Error> {
    let extents = extents(predictors, budget, sampler)?;
    let mut points: Vec<Option<PredictedPoint>> = vec![None; predictors.len()];
    for (members, (spectrum, moments)) in groups(&extents).iter().zip(&sums.groups) {
        let extent = &extents[members[0]];
        let mut group = select(predictors, members);
        let (_, mut predictions) = accumulators(&mut group, sampler.n_points(), extent)?;
        let spectrum = spectrum.finish()?;
        let found = predictions.iter_mut().zip(moments).map(|(prediction, moments)| {
            prediction.add(moments);
            PredictedPoint { spectrum: spectrum.clone(), prediction: prediction.finish() }
        });
        let found = found.collect();
        place(&mut points, members, group, found, (sampler, extent))?;
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
    let (space, options, has_spectra) = (first.space, first.options, first.has_spectra);
    let shown = |spectrum: &Spectrum<_>| {
        if has_spectra { spectrum.clone() } else { spectrum.first_band() }
    };
    match Route::of::<S>(&options, budget, sampler, extent) {
        Route::Flat => {
            let spectrum = if has_spectra {
                space.flat_spectrum(n_points, extent)?
            } else {
                Spectrum::exact(space.bands(extent), n_points, vec![1.0])
            };
            let point = |p: &&mut PredictorOn<'_, S>| PredictedPoint {
                spectrum: spectrum.clone(),
                prediction: p.flat_prediction(n_points),
            };
            Ok(predictors.iter().map(point).collect())
        }
        Route::Exact(exact) => {
            let spectrum = S::exact_spectrum(&first.workspaces, &exact, extent, progress)?;
            let point = |p: &mut &mut PredictorOn<'_, S>| {
                let prediction = predict_from(&spectrum, p.energies_to(extent)?);
                Ok(PredictedPoint { spectrum: shown(&spectrum), prediction })
            };
            predictors.iter_mut().map(point).collect()
        }
        Route::All(sets) => {
            let empty = accumulators(predictors, n_points, extent)?;
            let (all, size) = (0..sets.len() as u64, (n_points, extent));
            let workspaces = &predictors[0].workspaces;
            exactly(&S::accumulate(workspaces, &sets, &options, size, all, &empty, progress)?)
        }
        Route::Sampled if !S::distribution(sampler).is_random() => {
            let empty = accumulators(predictors, n_points, extent)?;
            let (first, size) = (&*predictors[0], (n_points, extent));
            let sets = first.realizations(Purpose::Pattern, sampler);
            let workspaces = &first.workspaces;
            exactly(&S::accumulate(workspaces, &sets, &options, size, 0..1, &empty, progress)?)
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
    let PredictorOn { space, has_spectra, .. } = *predictors[0];
    let spectrum = if has_spectra {
        space.empty_spectrum(n_points, extent)?
    } else {
        SpectrumAccumulator::new(space.bands(extent), n_points, 0)
    };
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
    let mut sum = accumulators(predictors, n_points, extent)?;
    let Some(predictor) = predictors.first() else { return Ok(Vec::new()) };
    let max = predictor.max_realizations(budget, sampler, extent);
    let (options, size) = (&predictor.options, (n_points, extent));
    let (workspaces, sets) =
        (&predictor.workspaces, predictor.realizations(Purpose::Pattern, sampler));
    let mut points: Vec<Option<PredictedPoint<S::Bands>>> = vec![None; predictors.len()];
    let empty = sum.clone();
    let mut count = 0;
    let mut next = predictor.options.realizations.unwrap_or(FIRST.min(max));
    loop {
        let range = count..next;
        sum.merge(&S::accumulate(workspaces, &sets, options, size, range, &empty, progress)?);
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

/// Returns whether an estimate whose number of realizations may be at most `max` ends with `count`, given
/// that one with a smaller maximum or a lower precision ended with that number.
///
/// Numbers of realizations double from [`FIRST`] to `max`. With a lower maximum, another number may have been the
/// last, from which no estimate with `max` ends.
pub(crate) fn is_last(count: u64, max: u64, is_precise: bool) -> bool {
    let doubles = count.is_multiple_of(FIRST) && (count / FIRST).is_power_of_two();
    count == max || is_precise && doubles && count < max
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
    let (workspaces, options) = (&predictor.workspaces, &predictor.options);
    let sums = S::accumulate(workspaces, &sets, options, size, all, &empty, progress)?;
    Ok(sums.1[0].finish())
}

#[cfg(test)]
mod tests {
    use super::is_last;

    #[test]
    fn an_estimate_ends_where_it_is_precise_or_exhausted() {
        // 8, 16, 32, 50.
        for (count, is_precise, expected) in [
            (8, true, true),
            (8, false, false),
            (16, true, true),
            (20, true, false),
            (4, true, false),
        ] {
            assert_eq!(is_last(count, 50, is_precise), expected, "{count}");
        }
        assert!(is_last(50, 50, false) && is_last(4, 4, false));
        assert!(!is_last(64, 50, true));
    }
}
