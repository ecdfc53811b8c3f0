//! The unit square.

use std::ops::Range;

use sphvar_integrands::{Energy, SquareIntegrand};
use sphvar_samplers::{
    Ensemble, PointSet, Progress, Square, SquareDistribution, SquareRealizations, SquareSampler,
    Streams,
};
use sphvar_sh::{Bands, Frequencies};
use sphvar_spectrum::{
    ExactSquareSpectrum, Spectrum, SpectrumAccumulator, SquareResolution, Workspaces,
    accumulate_square_with,
};

use super::frequencies::{prediction_frequencies, unresolved};
use super::{Distribution, IntegrationSpace, check_given};
use crate::predictor::Sums;
use crate::{Error, PredictionBudget, PredictorOn, SpectrumOptions};

/// The largest frequency of the estimated spectra that are kept beside predictions, whose errors
/// take some 250 bytes a band.
const MAX_KEPT: usize = 256;

/// Predicts the variance of integrating one function over the unit square with any pattern, under
/// uniform toroidal shifts.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::Wave;
/// use sphvar_samplers::SquarePattern;
/// use sphvar_variance::{PredictionBudget, SquarePredictor, Trials};
///
/// let wave = Wave::new([3, 0])?;
/// let mut predictor = SquarePredictor::new(&wave, 0, PredictionBudget::DEFAULT)?;
/// let jittered = SquarePattern::JitteredSquare.build(64)?;
/// let compared = predictor.compare(&*jittered, Trials::new(400), &())?;
/// // (1 - sinc^2(3/8))/(2 N), of which the measured variance differs by its error.
/// let sinc = (0.375 * std::f64::consts::PI).sin() / (0.375 * std::f64::consts::PI);
/// let expected = (1.0 - sinc * sinc) / 128.0;
/// assert!((compared.prediction.variance / expected - 1.0).abs() < 1e-12);
/// assert!(compared.z_score().abs() < 4.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type SquarePredictor<'a> = PredictorOn<'a, Square>;

impl<'a> SquarePredictor<'a> {
    /// Returns a predictor for an integrand; all realizations use the seed.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Integrand`] if the integrand's energies are unknown, and
    /// [`Error::Parameter`] for a precision that is not positive.
    pub fn new(
        integrand: &'a dyn SquareIntegrand,
        seed: u64,
        budget: PredictionBudget,
    ) -> Result<Self, Error> {
        Self::in_space(integrand, Square, seed, budget)
    }
}

impl IntegrationSpace for Square {
    type Bands = Frequencies;
    type SamplerRef<'s> = &'s dyn SquareSampler;
    type Integrand<'a> = &'a dyn SquareIntegrand;
    type Extent = Frequencies;
    type Level = (usize, usize);
    type Exact<'s> = ExactSquareSpectrum<'s>;
    type Realizations<'s> = SquareRealizations<'s>;

    fn area(self) -> f64 {
        1.0
    }

    fn sampler(owned: &dyn SquareSampler) -> &dyn SquareSampler {
        owned
    }

    fn check(self, sampler: &dyn SquareSampler) -> Result<(), Error> {
        check_given(sampler.n_points(), Self::given_sets(sampler))
    }

    fn n_points(sampler: &dyn SquareSampler) -> usize {
        sampler.n_points()
    }

    fn nominal_work(sampler: &dyn SquareSampler) -> f64 {
        sampler.nominal_work()
    }

    fn stream_group(sampler: &dyn SquareSampler) -> usize {
        sampler.stream_group()
    }

    fn is_independent(sampler: &dyn SquareSampler) -> bool {
        sampler.is_independent()
    }

    fn given_sets(sampler: Self::SamplerRef<'_>) -> &[PointSet<[f64; 2]>] {
        match sampler.distribution() {
            SquareDistribution::OneOf(sets) => sets,
            _ => &[],
        }
    }

    fn coordinates(&[u, v]: &[f64; 2]) -> [f64; 3] {
        [u, v, 0.0]
    }

    fn distribution(sampler: Self::SamplerRef<'_>) -> Distribution<'_, [f64; 2]> {
        match sampler.distribution() {
            SquareDistribution::Independent => Distribution::Independent,
            SquareDistribution::OneOf(sets) if sets.len() > 1 => Distribution::OneOf(sets),
            kind if kind.is_random() => Distribution::Random,
            _ => Distribution::Fixed,
        }
    }

    fn realizations(sampler: Self::SamplerRef<'_>, streams: Streams) -> SquareRealizations<'_> {
        SquareRealizations::shifted(sampler, streams)
    }

    fn extent(
        predictor: &mut SquarePredictor<'_>,
        budget: PredictionBudget,
        sampler: &dyn SquareSampler,
    ) -> Result<Frequencies, Error> {
        prediction_frequencies(predictor, budget, sampler)
    }

    fn bands(self, frequencies: &Frequencies) -> Frequencies {
        frequencies.clone()
    }

    fn last_band(frequencies: &Frequencies) -> usize {
        frequencies.len() - 1
    }

    fn last_of(spectrum: &Spectrum<Frequencies>) -> usize {
        Self::last_band(spectrum.bands())
    }

    fn transform_work(n_points: usize, frequencies: &Frequencies) -> f64 {
        SquareResolution::new(frequencies.clone()).nominal_work(n_points)
    }

    fn ticked_work(_: &SpectrumOptions, n_points: usize, frequencies: &Frequencies) -> f64 {
        Self::transform_work(n_points, frequencies)
    }

    fn exact<'s>(
        options: &SpectrumOptions,
        _: PredictionBudget,
        sampler: Self::SamplerRef<'s>,
        _: &Frequencies,
    ) -> Option<ExactSquareSpectrum<'s>> {
        let is_chosen = if sampler.is_random() {
            options.realizations.is_none()
        } else {
            options.is_default_transform()
        };
        ExactSquareSpectrum::of(sampler).filter(|_| is_chosen)
    }

    fn exact_spectrum(
        workspaces: &Workspaces,
        exact: &ExactSquareSpectrum<'_>,
        frequencies: &Frequencies,
        progress: &dyn Progress,
    ) -> Result<Spectrum<Frequencies>, Error> {
        Ok(exact.to_with(workspaces, frequencies, progress)?)
    }

    fn exact_work(exact: &ExactSquareSpectrum<'_>, frequencies: &Frequencies) -> f64 {
        exact.work(frequencies)
    }

    fn flat_spectrum(
        self,
        n_points: usize,
        frequencies: &Frequencies,
    ) -> Result<Spectrum<Frequencies>, Error> {
        let kept = kept(frequencies)?;
        let power = vec![1.0; kept.len()];
        Ok(Spectrum::exact(kept, n_points, power))
    }

    fn empty_spectrum(
        self,
        n_points: usize,
        frequencies: &Frequencies,
    ) -> Result<SpectrumAccumulator<Frequencies>, Error> {
        let kept = kept(frequencies)?;
        let last = kept.len() - 1;
        Ok(SpectrumAccumulator::new(kept, n_points, last))
    }

    fn accumulate(
        workspaces: &Workspaces,
        sets: &dyn Ensemble<[f64; 2]>,
        options: &SpectrumOptions,
        (_, frequencies): (usize, &Frequencies),
        indices: Range<u64>,
        empty: &Sums<Frequencies>,
        progress: &dyn Progress,
    ) -> Result<Sums<Frequencies>, Error> {
        let (frequencies, epsilon) = (frequencies.clone(), options.epsilon);
        let resolution = SquareResolution { frequencies, epsilon };
        Ok(accumulate_square_with(workspaces, sets, &resolution, indices, empty, progress)?)
    }

    fn outline(self, integrand: &dyn SquareIntegrand) -> Result<Energy<Frequencies>, Error> {
        let none = Frequencies::new(0).map_err(sphvar_integrands::Error::from)?;
        let outline = integrand.energy(&none)?;
        outline.check_magnitude()?;
        Ok(outline)
    }

    fn level(frequencies: &Frequencies) -> (usize, usize) {
        (frequencies.kmax(), frequencies.axis_max())
    }

    fn energy(
        self,
        integrand: &dyn SquareIntegrand,
        frequencies: &Frequencies,
        announce: &dyn Fn(usize),
    ) -> Result<Energy<Frequencies>, Error> {
        announce(frequencies.kmax());
        Ok(integrand.energy(frequencies)?)
    }

    /// Lattices integrate smooth functions so well that the energy at few frequencies far from 0,
    /// where they have power N, is all of their variance.
    fn hidden_tail(
        predictor: &mut SquarePredictor<'_>,
        sampler: &dyn SquareSampler,
        frequencies: &Frequencies,
    ) -> Result<f64, Error> {
        let limit = predictor.integrand().band_limit().unwrap_or(usize::MAX);
        if sampler.is_random() || limit <= frequencies.kmax() {
            return Ok(0.0);
        }
        let energy = predictor.energies_to(frequencies)?;
        Ok(energy.bands().factor(sampler.n_points()) * unresolved(energy))
    }

    /// Stratified patterns have less power than white noise at all frequencies close to an axis,
    /// where smooth functions have theirs, so there is no bound.
    fn min_variance(_: &mut SquarePredictor<'_>, _: usize, _: bool) -> Result<f64, Error> {
        Ok(0.0)
    }

    fn integral(self, integrand: &dyn SquareIntegrand) -> Option<f64> {
        integrand.exact()
    }

    fn kurtosis(self, integrand: &dyn SquareIntegrand) -> Option<f64> {
        integrand.kurtosis()
    }

    fn eval_into(
        integrand: &dyn SquareIntegrand,
        points: &[[f64; 2]],
        values: &mut [f64],
    ) -> Result<(), sphvar_integrands::Error> {
        integrand.eval_into(points, values)
    }
}

/// Returns the frequencies of the spectrum that is kept beside a prediction: the first bands of
/// those of the prediction.
fn kept(frequencies: &Frequencies) -> Result<Frequencies, Error> {
    let kept = Frequencies::new(frequencies.kmax().min(MAX_KEPT));
    Ok(kept.map_err(sphvar_integrands::Error::from)?)
}
