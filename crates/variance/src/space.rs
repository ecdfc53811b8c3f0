//! The spaces on which functions are integrated.

mod frequencies;
mod sphere;
mod square;

pub(crate) use self::frequencies::prefix_frequencies;
pub use self::square::SquarePredictor;

use std::ops::Range;

use sphvar_integrands::Energy;
use sphvar_samplers::{Ensemble, PointSet, Progress, Space, Streams};
use sphvar_spectrum::{SpectralBands, Spectrum, SpectrumAccumulator, Workspaces};

use crate::predictor::Sums;
use crate::{Error, PredictionBudget, PredictorOn, SpectrumOptions};

/// A space on which functions are integrated, with its samplers, spectra and integrands:
/// [`Domain`](crate::Domain), the sphere and the hemisphere, and the unit [`Square`](crate::Square).
///
/// [`PredictorOn`] and everything that follows from predictions and measurements are written over
/// it. It is not meant to be implemented outside this crate.
pub trait IntegrationSpace: Space {
    /// The bands of spectra.
    type Bands: SpectralBands<Point = Self::Point>;
    /// A reference to a sampler.
    type SamplerRef<'s>: Copy;
    /// A reference to an integrand.
    type Integrand<'a>: Copy + Sync;
    /// How far a spectrum extends: the largest degree.
    type Extent: Clone + PartialEq;
    /// The extents whose energies are computed together.
    type Level: Ord;
    /// A spectrum in closed form.
    type Exact<'s>;
    /// The homogeneous ensemble of a sampler.
    type Realizations<'s>: Ensemble<Self::Point>;

    /// Returns the area.
    fn area(self) -> f64;

    /// Returns a reference to a sampler.
    fn sampler(owned: &Self::Sampler) -> Self::SamplerRef<'_>;

    /// Checks that a sampler is one of this space and estimates integrals.
    ///
    /// # Errors
    ///
    /// Returns [`Error::OtherDomain`] or the error of the sampler.
    fn check(self, sampler: Self::SamplerRef<'_>) -> Result<(), Error>;

    /// Returns the number of points of a sampler.
    fn n_points(sampler: Self::SamplerRef<'_>) -> usize;

    /// Returns the nominal work of a realization.
    fn nominal_work(sampler: Self::SamplerRef<'_>) -> f64;

    /// Returns a number that distinguishes the random streams of a sampler.
    fn stream_group(sampler: Self::SamplerRef<'_>) -> usize;

    /// Returns whether the points of a realization are independent and uniformly distributed.
    fn is_independent(sampler: Self::SamplerRef<'_>) -> bool;

    /// Returns the sets of which a sampler draws one uniformly, if they are given.
    fn given_sets(sampler: Self::SamplerRef<'_>) -> &[PointSet<Self::Point>];

    /// Returns the coordinates of a point, of which unused ones are 0.
    fn coordinates(point: &Self::Point) -> [f64; 3];

    /// Returns the known properties of the distribution of a sampler.
    fn distribution(sampler: Self::SamplerRef<'_>) -> Distribution<'_, Self::Point>;

    /// Returns the realizations of a sampler, randomized so that they are homogeneous.
    fn realizations(sampler: Self::SamplerRef<'_>, streams: Streams) -> Self::Realizations<'_>;

    /// Returns how far the spectrum of a sampler is computed for a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn extent(
        predictor: &mut PredictorOn<'_, Self>,
        budget: PredictionBudget,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Self::Extent, Error>;

    /// Returns the bands of spectra of an extent.
    fn bands(self, extent: &Self::Extent) -> Self::Bands;

    /// Returns the last band of a spectrum.
    fn last_band(extent: &Self::Extent) -> usize;

    /// Returns [`Self::last_band`] of the extent of a prediction, given the spectrum kept beside it; a
    /// lower band where not all of the spectrum is kept.
    fn last_of(spectrum: &Spectrum<Self::Bands>) -> usize;

    /// Returns the nominal work of transforming a set of `n_points`, from which numbers of
    /// realizations follow.
    fn transform_work(n_points: usize, extent: &Self::Extent) -> f64;

    /// Returns the nominal work that the transform of a set of `n_points` ticks.
    fn ticked_work(options: &SpectrumOptions, n_points: usize, extent: &Self::Extent) -> f64;

    /// Returns the closed form by which the spectrum of a sampler is computed; `None` if it is
    /// estimated.
    fn exact<'s>(
        options: &SpectrumOptions,
        budget: PredictionBudget,
        sampler: Self::SamplerRef<'s>,
        extent: &Self::Extent,
    ) -> Option<Self::Exact<'s>>;

    /// Returns the spectrum in closed form.
    ///
    /// # Errors
    ///
    /// Returns the errors of the closed form, and an error if `progress` stops the work.
    fn exact_spectrum(
        workspaces: &Workspaces,
        exact: &Self::Exact<'_>,
        extent: &Self::Extent,
        progress: &dyn Progress,
    ) -> Result<Spectrum<Self::Bands>, Error>;

    /// Returns the nominal work of [`exact_spectrum`](Self::exact_spectrum).
    fn exact_work(exact: &Self::Exact<'_>, extent: &Self::Extent) -> f64;

    /// Returns the spectrum with power 1 in every band, that of independent points.
    ///
    /// # Errors
    ///
    /// Returns an error if memory is exhausted.
    fn flat_spectrum(
        self,
        n_points: usize,
        extent: &Self::Extent,
    ) -> Result<Spectrum<Self::Bands>, Error>;

    /// Returns the empty sums of the spectrum that is shown.
    ///
    /// # Errors
    ///
    /// Returns an error if there is no transform to this extent.
    fn empty_spectrum(
        self,
        n_points: usize,
        extent: &Self::Extent,
    ) -> Result<SpectrumAccumulator<Self::Bands>, Error>;

    /// Adds the sets of an ensemble to a copy of empty sums.
    ///
    /// # Errors
    ///
    /// Returns the errors of sampler and transform, and an error if `progress` stops the work.
    fn accumulate(
        workspaces: &Workspaces,
        sets: &dyn Ensemble<Self::Point>,
        options: &SpectrumOptions,
        size: (usize, &Self::Extent),
        indices: Range<u64>,
        empty: &Sums<Self::Bands>,
        progress: &dyn Progress,
    ) -> Result<Sums<Self::Bands>, Error>;

    /// Returns the energy of the mean and the total energy of an integrand.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand, and an error for an integrand whose size is out of
    /// range.
    fn outline(self, integrand: Self::Integrand<'_>) -> Result<Energy<Self::Bands>, Error>;

    /// Returns the level of energies that a spectrum needs.
    fn level(extent: &Self::Extent) -> Self::Level;

    /// Returns the energies of an integrand to an extent or somewhat beyond. Calls `announce` with
    /// the largest degree first.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand.
    fn energy(
        self,
        integrand: Self::Integrand<'_>,
        extent: &Self::Extent,
        announce: &dyn Fn(usize),
    ) -> Result<Energy<Self::Bands>, Error>;

    /// Returns the part of a predicted variance that rounding of the energies can hide beyond the
    /// spectrum; 0 if spectra extend until such energies do not matter.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn hidden_tail(
        _predictor: &mut PredictorOn<'_, Self>,
        _sampler: Self::SamplerRef<'_>,
        _extent: &Self::Extent,
    ) -> Result<f64, Error> {
        Ok(0.0)
    }

    /// Returns a lower bound of the variance with `n_points` of any pattern that is random, or
    /// always the same, and not independent; 0 if there is none.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn min_variance(
        predictor: &mut PredictorOn<'_, Self>,
        n_points: usize,
        is_random: bool,
    ) -> Result<f64, Error>;

    /// Returns the exact integral, if it is known.
    fn integral(self, integrand: Self::Integrand<'_>) -> Option<f64>;

    /// Returns the kurtosis of the integrand's values, if it is available.
    fn kurtosis(self, integrand: Self::Integrand<'_>) -> Option<f64>;

    /// Writes the values of the integrand at points.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand.
    fn eval_into(
        integrand: Self::Integrand<'_>,
        points: &[Self::Point],
        values: &mut [f64],
    ) -> Result<(), sphvar_integrands::Error>;
}

/// The known properties of the distribution of a sampler that decide how its spectrum is computed.
#[derive(Clone, Copy, Debug)]
pub enum Distribution<'s, P> {
    /// Independent uniform points.
    Independent,
    /// One of several given sets, drawn uniformly.
    OneOf(&'s [PointSet<P>]),
    /// Always the same set, up to the randomization.
    Fixed,
    /// Any other distribution.
    Random,
}

impl<P> Distribution<'_, P> {
    /// Returns whether two realizations can differ by more than the randomization.
    #[must_use]
    pub fn is_random(&self) -> bool {
        !matches!(self, Self::Fixed)
    }
}

/// Checks that a sampler has points, and that each of its given sets estimates integrals.
fn check_given<P>(n_points: usize, sets: &[PointSet<P>]) -> Result<(), Error> {
    let wrong = |reason| Err(sphvar_samplers::Error::Given { reason }.into());
    if n_points == 0 {
        return wrong("a sampler has no points".to_owned());
    }
    match sets.iter().position(|set| set.n_effective() <= 0.0) {
        Some(i) => wrong(format!("set {i} has weights whose sum is 0, which estimate no integral")),
        None => Ok(()),
    }
}
