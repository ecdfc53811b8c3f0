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

/// Returns the default frequencies to which a spectrum is computed for predicting the variance of
/// an integrand.
///
/// Off the axes these are the frequencies up to 4 sqrt(N), at most 2048, beyond which the power of
/// a random pattern is 1. A lattice or a given set has peaks at all frequencies, and only their mean
/// is 1: they extend to 40 sqrt(N), at most 1024, unless the energy beyond is negligible before. On
/// the axes they extend to 8 N, at most 65536, since projections of N points have peaks at
/// multiples of up to N. None exceeds the integrand's band limit.
pub(super) fn prediction_frequencies(
    predictor: &mut SquarePredictor<'_>,
    budget: PredictionBudget,
    sampler: &dyn SquareSampler,
) -> Result<Frequencies, Error> {
    let n_points = sampler.n_points();
    let limit = predictor.integrand().band_limit().unwrap_or(usize::MAX);
    let on_axes = n_points.saturating_mul(8).min(MAX_AXIS).min(limit);
    let frequencies = |kmax: usize| {
        let all = Frequencies::new(kmax).and_then(|f| f.with_axes(on_axes.max(kmax)));
        all.map_err(sphvar_integrands::Error::from)
    };
    if let Some(kmax) = predictor.options().lmax {
        return Ok(frequencies(kmax)?);
    }
    let natural = SquareResolution::natural_frequency(n_points).min(MAX_FREQUENCY);
    let min = natural.min(limit);
    match sampler.distribution() {
        // If there are few given sets, each may be a lattice.
        SquareDistribution::OneOf(sets) => {
            let work = realization_work::<Square>(sampler, &frequencies(min)?);
            if sets.len() as u64 > budget.realizations_of(work) {
                return Ok(frequencies(min)?);
            }
        }
        SquareDistribution::Fixed | SquareDistribution::Lattice(_) => {}
        _ => return Ok(frequencies(min)?),
    }
    let max = natural.saturating_mul(10).min(MAX_OF_LATTICES).max(natural).min(limit);
    // The mean power of a lattice off the axes is 1 from about 2 sqrt(N) on, so the energy beyond
    // approximates its variance there.
    let settled = frequencies(min / 2)?.len();
    let mut kmax = min;
    loop {
        let all = frequencies(kmax)?;
        let energy = predictor.energies_to(&all)?;
        let beyond = energy.beyond_by_class(all.len() - 1).get(0).max(unresolved(energy));
        let bands = energy.per_band().iter().enumerate().skip(settled);
        let known: f64 = bands.filter(|(b, _)| all.tail_class(*b) == 0).map(|(_, e)| e).sum();
        let is_negligible = beyond <= negligible(budget) * (known + beyond);
        // Estimated energies end at some frequency; spectra beyond it are of no use.
        if is_negligible || kmax >= max || energy.lmax() + 1 < all.len() {
            return Ok(all);
        }
        kmax = kmax.saturating_mul(2).min(max);
    }
}

/// Returns the energy beyond known bands that the rounding of their sum hides, a bound of the
/// differences that [`Energy::beyond_by_class`] replaces by 0.
pub(super) fn unresolved(energy: &Energy<Frequencies>) -> f64 {
    let n_bands = energy.per_band().len() as f64;
    4.0 * f64::EPSILON * energy.centred().sum() * n_bands.sqrt()
}
