use std::ops::Range;

use serde::{Deserialize, Serialize};
use sphvar_sh::Frequencies;
use sphvar_spectrum::{
    Accumulator, AxisRatio, AxisRatioAccumulator, RadialAccumulator, RadialSpectrum, Spectrum,
    SpectrumAccumulator, SquareResolution, accumulate_square,
};

use crate::{Error, PlaneEnsemble};

/// The mean power of point sets of the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSpectrum {
    /// Per frequency; for a single set, without errors.
    pub spectrum: Spectrum<Frequencies>,
    /// Means over rings of frequencies, with the errors of realizations.
    pub radial: RadialSpectrum,
    /// The power on the axes at low frequencies, relative to that off the axes.
    pub axes: AxisRatio,
}

/// The sums of a piece.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PlaneSums {
    spectrum: SpectrumAccumulator<Frequencies>,
    radial: RadialAccumulator,
    axes: AxisRatioAccumulator,
}

impl PlaneSums {
    /// Returns the sums over a range of sets, for frequencies to `kmax`.
    pub(crate) fn run(
        ensemble: &PlaneEnsemble,
        kmax: usize,
        seed: u64,
        sets: Range<u64>,
    ) -> Result<Self, Error> {
        let frequencies = Frequencies::new(kmax)?;
        let empty = (
            (
                SpectrumAccumulator::of_square(frequencies.clone(), ensemble.n_points)?,
                RadialAccumulator::new(frequencies.clone()),
            ),
            AxisRatioAccumulator::new(frequencies.clone(), low_radius(ensemble.n_points))?,
        );
        let sampler = ensemble.sampler()?;
        let all = ensemble.realizations(&*sampler, seed);
        let resolution = SquareResolution::new(frequencies);
        let ((spectrum, radial), axes) = accumulate_square(&all, &resolution, sets, &empty, &())?;
        Ok(Self { spectrum, radial, axes })
    }

    /// Returns whether these are sums over the given number of sets of an ensemble.
    pub(crate) fn fits(&self, ensemble: &PlaneEnsemble, kmax: usize, sets: u64) -> bool {
        let is_of_job = |frequencies: &Frequencies| {
            frequencies.kmax() == kmax && frequencies.axis_max() == kmax
        };
        is_of_job(self.spectrum.bands())
            && is_of_job(self.radial.frequencies())
            && is_of_job(self.axes.frequencies())
            && self.spectrum.n_points() == ensemble.n_points
            && self.spectrum.lmax() == Some(self.spectrum.bands().len() - 1)
            && self.axes.radius() == low_radius(ensemble.n_points)
            && self.spectrum.realizations() == Some(sets)
            && self.radial.realizations() == Some(sets)
            && self.axes.realizations() == Some(sets)
    }

    /// Adds the sums of another piece of the same job.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.spectrum.merge(&other.spectrum);
        self.radial.merge(&other.radial);
        self.axes.merge(&other.axes);
    }

    /// Returns the means; `is_single` for one set, which has no errors.
    pub(crate) fn finish(&self, is_single: bool) -> Result<PlaneSpectrum, Error> {
        let spectrum = self.spectrum.finish()?;
        let spectrum = if is_single { spectrum.into_exact() } else { spectrum };
        let radial = RadialSpectrum::of(&spectrum);
        let radial = if is_single { radial } else { radial.with_errors(&self.radial)? };
        Ok(PlaneSpectrum { spectrum, radial, axes: self.axes.finish()? })
    }
}

/// Returns the largest frequency of the ratio of axes: omega = 1/4.
fn low_radius(n_points: usize) -> usize {
    (n_points.isqrt() / 4).max(2)
}

/// Returns the nominal work of a set and its transform.
pub(crate) fn work(ensemble: &PlaneEnsemble, kmax: usize) -> f64 {
    // kmax is far below the limit of the table, which is small.
    let transform = Frequencies::new(kmax).map_or(0.0, |frequencies| {
        SquareResolution::new(frequencies).nominal_work(ensemble.n_points)
    });
    ensemble.pattern.nominal_work(ensemble.n_points) + transform
}
