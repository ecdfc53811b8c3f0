use sphvar_samplers::{Progress, Realizations};

use crate::{Error, Resolution, Spectrum, SpectrumAccumulator, accumulate};

/// Returns the mean spectrum of a sampler to degree `lmax`, over `realizations` sets. Ticks
/// `progress` with the nominal work of sampling and transforming.
///
/// A deterministic pattern has the same spectrum in every rotation: one set is transformed, and the
/// standard error is 0.
///
/// # Errors
///
/// [`Error::NoRealizations`] if `realizations` is 0; [`Error::Transform`] if `lmax` is out of
/// range; [`Error::Sampler`] if a set cannot be generated or `progress` stops the work.
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
