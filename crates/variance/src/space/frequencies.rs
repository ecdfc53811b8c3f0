//! The frequencies to which spectra on the square are computed.

use sphvar_integrands::Energy;
use sphvar_samplers::{Square, SquareDistribution, SquareSampler};
use sphvar_sh::{Bands, Frequencies, TailClasses};
use sphvar_spectrum::SquareResolution;

use super::SquarePredictor;
use crate::predictor::{negligible, realization_work};
use crate::{Error, PredictionBudget};

/// The largest frequency of default spectra off the axes: there are 6.6e6 pairs within it.
const MAX_FREQUENCY: usize = 2048;
/// The largest one of lattices, unless random patterns need more.
const MAX_OF_LATTICES: usize = 1024;
/// The largest frequency on the axes.
const MAX_AXIS: usize = 1 << 16;
/// The least frequency to which lattices extend on the axes.
const MIN_AXIS_OF_LATTICES: usize = 1 << 13;

/// Returns the default frequencies to which a spectrum is computed for predicting the variance of
/// an integrand.
///
/// Off the axes these are the frequencies up to 4 sqrt(N), at most 2048, beyond which the power of
/// a random pattern is 1. On the axes they extend to 8 N, at most 65536, since projections of N
/// points have peaks at multiples of up to N. Lattices and few given sets have those of
/// [`lattice_frequencies`]. None exceeds the integrand's band limit.
pub(super) fn prediction_frequencies(
    predictor: &mut SquarePredictor<'_>,
    budget: PredictionBudget,
    sampler: &dyn SquareSampler,
) -> Result<Frequencies, Error> {
    let n_points = sampler.n_points();
    let limit = predictor.integrand().band_limit().unwrap_or(usize::MAX);
    let axis = axis_maximum(n_points).min(limit);
    if let Some(kmax) = predictor.options().lmax {
        return frequencies(predictor, kmax, axis);
    }
    let natural = natural_frequency(n_points).min(limit);
    match sampler.distribution() {
        // If there are few given sets, each may be a lattice.
        SquareDistribution::OneOf(sets) => {
            let random = frequencies(predictor, natural, axis)?;
            let work = realization_work::<Square>(sampler, &random);
            if sets.len() as u64 > budget.realizations_of(work) {
                return Ok(random);
            }
            lattice_frequencies(predictor, budget, sampler)
        }
        SquareDistribution::Fixed | SquareDistribution::Lattice(_) => {
            lattice_frequencies(predictor, budget, sampler)
        }
        _ => frequencies(predictor, natural, axis),
    }
}

/// Returns the frequencies for all prefixes of a sequence, to which every point adds a term for each
/// of them: those of [`prediction_frequencies`] for a random pattern.
pub(crate) fn prefix_frequencies(
    predictor: &SquarePredictor<'_>,
    sampler: &dyn SquareSampler,
) -> Result<Frequencies, Error> {
    let limit = predictor.integrand().band_limit().unwrap_or(usize::MAX);
    let natural = natural_frequency(sampler.n_points()).min(limit);
    let kmax = predictor.options().lmax.unwrap_or(natural);
    frequencies(predictor, kmax, axis_maximum(sampler.n_points()).min(limit))
}

/// Returns the frequencies for a pattern that may be a lattice, which has peaks at all frequencies:
/// only their mean is 1.
///
/// They extend to 40 sqrt(N), at most 1024, unless the energy beyond is negligible before or the
/// work of the transform exceeds the budget. Frequencies are rounded up to powers of two, so that
/// predictions with different numbers of points share the energies of the integrand.
fn lattice_frequencies(
    predictor: &mut SquarePredictor<'_>,
    budget: PredictionBudget,
    sampler: &dyn SquareSampler,
) -> Result<Frequencies, Error> {
    let n_points = sampler.n_points();
    let limit = predictor.integrand().band_limit().unwrap_or(usize::MAX);
    let axis = axis_maximum(n_points).next_power_of_two().max(MIN_AXIS_OF_LATTICES).min(limit);
    let natural = natural_frequency(n_points);
    let level = |kmax: usize| kmax.next_power_of_two().min(MAX_OF_LATTICES).max(natural);
    let (min, max) = (level(natural).min(limit), level(10 * natural).min(limit));
    // The mean power of a lattice off the axes is 1 from about 2 sqrt(N) on, so the energy beyond
    // approximates its variance there.
    let settled = square_bands(natural.min(limit) / 2, 0)?.len();
    let mut all = frequencies(predictor, min, axis)?;
    while all.kmax() < max {
        let energy = predictor.energies_to(&all)?;
        let beyond = energy.beyond_by_class(all.len() - 1).get(0).max(unresolved(energy));
        let bands = energy.per_band().iter().enumerate().skip(settled);
        let known: f64 = bands.filter(|(b, _)| all.tail_class(*b) == 0).map(|(_, e)| e).sum();
        let is_negligible = beyond <= negligible(budget) * (known + beyond);
        // Estimated energies end at some frequency; spectra beyond it are of no use.
        if is_negligible || energy.lmax() + 1 < all.len() {
            break;
        }
        let more = frequencies(predictor, all.kmax().saturating_mul(2).min(max), axis)?;
        if realization_work::<Square>(sampler, &more) > budget.work {
            break;
        }
        // Energies that are not known off the axes end there on the axes too, which extend further.
        let last = predictor.energies_to(&more)?.lmax();
        if more.radius(last) < all.radius(all.len() - 1) {
            break;
        }
        all = more;
    }
    Ok(all)
}

/// Returns the frequency beyond which the power of random patterns is 1.
fn natural_frequency(n_points: usize) -> usize {
    SquareResolution::natural_frequency(n_points).min(MAX_FREQUENCY)
}

/// Returns the largest frequency on the axes.
fn axis_maximum(n_points: usize) -> usize {
    n_points.saturating_mul(8).min(MAX_AXIS)
}

/// Returns the frequencies up to kmax and on the axes up to a larger limit, those of known energies
/// if there are any.
fn frequencies(
    predictor: &SquarePredictor<'_>,
    kmax: usize,
    axis_max: usize,
) -> Result<Frequencies, Error> {
    let axis_max = axis_max.max(kmax);
    match predictor.known_energies(&(kmax, axis_max)) {
        Some(known) => Ok(known.bands().clone()),
        None => square_bands(kmax, axis_max),
    }
}

fn square_bands(kmax: usize, axis_max: usize) -> Result<Frequencies, Error> {
    let bands = Frequencies::new(kmax).and_then(|within| within.with_axes(axis_max.max(kmax)));
    Ok(bands.map_err(sphvar_integrands::Error::from)?)
}

/// Returns the energy beyond known bands that the rounding of their sum hides, a bound of the
/// differences that [`Energy::beyond_by_class`] replaces by 0.
pub(super) fn unresolved(energy: &Energy<Frequencies>) -> f64 {
    let n_bands = energy.per_band().len() as f64;
    4.0 * f64::EPSILON * energy.centred().sum() * n_bands.sqrt()
}
