use std::ops::Range;

use sphvar_samplers::{Ensemble, Progress, SquareRealizations};
use sphvar_sh::Frequencies;

use super::transform::SquareTransform;
use crate::accumulate::accumulate_by;
use crate::{Accumulator, Error, Spectrum, SpectrumAccumulator, SquareResolution, Workspaces};

/// Transforms the sets of points of the square with the given indices and accumulates them into a
/// copy of `empty`, in parallel over the sets, as [`accumulate`](crate::accumulate) does on the
/// sphere. Ticks `progress` with the nominal work of sampling and transforming.
///
/// # Errors
///
/// [`Error::Sampler`] if a set cannot be generated or `progress` stops the work;
/// [`Error::SquareTransform`] if the accuracy is out of range or a point is outside [0, 1)^2.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Purpose, SquarePattern, SquareRealizations, Streams};
/// use sphvar_sh::{ByAxis, Frequencies};
/// use sphvar_spectrum::{SpectrumAccumulator, SquareResolution, accumulate_square};
///
/// let white = SquarePattern::WhiteSquare.build(16)?;
/// let sets = SquareRealizations::shifted(&*white, Streams::new(0, Purpose::Pattern, 16));
/// let resolution = SquareResolution::new(Frequencies::new(8)?);
/// let empty = SpectrumAccumulator::of_square(resolution.frequencies.clone(), 16)?;
/// let spectrum = accumulate_square(&sets, &resolution, 0..20, &empty, &())?.finish()?;
/// assert_eq!(spectrum.realizations(), 20);
/// assert_eq!(spectrum.tail(), ByAxis { off: 1.0, u: 1.0, v: 1.0 });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn accumulate_square<A: Accumulator<Frequencies>>(
    sets: &dyn Ensemble<[f64; 2]>,
    resolution: &SquareResolution,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    accumulate_square_with(&Workspaces::default(), sets, resolution, indices, empty, progress)
}

/// Returns the result of [`accumulate_square`], with buffers that are kept for other calls.
///
/// # Errors
///
/// The errors of [`accumulate_square`].
pub fn accumulate_square_with<A: Accumulator<Frequencies>>(
    workspaces: &Workspaces,
    sets: &dyn Ensemble<[f64; 2]>,
    resolution: &SquareResolution,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    let transform = SquareTransform::new(resolution)?;
    accumulate_by(&transform, &workspaces.square, sets, indices, empty, progress)
}

/// Returns the mean spectrum of a sampler of the square, over `realizations` sets. Ticks `progress`
/// with the nominal work of sampling and transforming.
///
/// A pattern that is always the same set up to a shift has the same spectrum in every realization:
/// one set is transformed, and the standard error is 0.
///
/// # Errors
///
/// [`Error::NoRealizations`] if `realizations` is 0; [`Error::Frequencies`] as for
/// [`SpectrumAccumulator::of_square`]; [`Error::Sampler`] if a set cannot be generated or
/// `progress` stops the work.
pub fn estimate_square(
    ensemble: &SquareRealizations<'_>,
    frequencies: &Frequencies,
    realizations: u64,
    progress: &dyn Progress,
) -> Result<Spectrum<Frequencies>, Error> {
    let sampler = ensemble.sampler();
    let count = if sampler.is_random() { realizations } else { realizations.min(1) };
    let empty = SpectrumAccumulator::of_square(frequencies.clone(), sampler.n_points())?;
    let resolution = SquareResolution::new(frequencies.clone());
    let spectrum =
        accumulate_square(ensemble, &resolution, 0..count, &empty, progress)?.finish()?;
    Ok(if sampler.is_random() { spectrum } else { spectrum.into_exact() })
}

impl SpectrumAccumulator<Frequencies> {
    /// Returns an empty accumulator for all bands and sets of `n_points`.
    ///
    /// # Errors
    ///
    /// [`Error::Frequencies`] if kmax exceeds [`SquareResolution::MAX_KMAX_WITH_ERRORS`]: exact
    /// sums of that many bands do not fit in memory. Predictions, which need no error for every
    /// band, have no such limit.
    pub fn of_square(frequencies: Frequencies, n_points: usize) -> Result<Self, Error> {
        let (kmax, max) = (frequencies.kmax(), SquareResolution::MAX_KMAX_WITH_ERRORS);
        if kmax > max {
            return Err(Error::Frequencies { kmax, max });
        }
        let last = frequencies.len() - 1;
        Ok(Self::new(frequencies, n_points, last))
    }
}
