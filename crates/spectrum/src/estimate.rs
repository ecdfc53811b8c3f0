use sphvar_samplers::{Progress, Realizations};

use crate::{Error, Resolution, Spectrum, SpectrumAccumulator, accumulate};

/// The mean spectrum of a sampler to degree `lmax`, over `realizations` sets; the nominal work of making and
/// transforming them is ticked.
///
/// A pattern that is not random has the same spectrum in every rotation, so one set is
/// transformed and the standard error is 0.
///
/// # Errors
///
/// [`Error::NoRealizations`] for none, [`Error::Transform`] if `lmax` is out of range, [`Error::Sampler`] if a set cannot
/// be made or `progress` ends the work.
pub fn estimate(
    ensemble: &Realizations<'_>,
    lmax: usize,
    realizations: u64,
    progress: &dyn Progress,
) -> Result<Spectrum, Error> {
    let sampler = ensemble.sampler();
    let count = if sampler.is_random() { realizations } else { realizations.min(1) };
    let empty = SpectrumAccumulator::new(sampler.domain(), sampler.n_points(), lmax);
    let resolution = Resolution::new(lmax, sampler.n_points());
    let spectrum = accumulate(ensemble, resolution, 0..count, &empty, progress)?.finish()?;
    Ok(if sampler.is_random() { spectrum } else { spectrum.into_exact() })
}
