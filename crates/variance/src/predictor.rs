mod sphere;
mod together;
mod white_noise;

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use sphvar_samplers::{Domain, Ensemble, Progress, Purpose, Streams};
use sphvar_sh::{Bands, TailClasses};
use sphvar_spectrum::{Spectrum, Workspaces};

use crate::route::Route;
use crate::space::IntegrationSpace;
use crate::{Error, PredictedPoint, Prediction, PredictionBudget, SpectrumOptions};
use sphvar_integrands::{Energy, EnergyErrors};

pub(crate) use self::sphere::negligible;
pub use self::together::PredictionSums;
pub(crate) use self::together::{
    Sums, predict as predict_together, predict_from_sets, predict_from_sums, sums as sums_together,
};
pub(crate) use self::white_noise::ROUNDING;

/// Predicts the variance of integrating one function over the sphere or the hemisphere with any
/// sampler.
pub type Predictor<'a> = PredictorOn<'a, Domain>;

/// Predicts the variance of integrating one function with any sampler. All predictions are made by
/// this type.
///
/// It stores the integrand's energies and computes those of higher degrees when a number of points
/// requires them; white noise requires none. A prediction depends only on the seed, the sampler,
/// the [`PredictionBudget`] and the [`SpectrumOptions`], not on earlier predictions or on the
/// command.
pub struct PredictorOn<'a, S: IntegrationSpace> {
    integrand: S::Integrand<'a>,
    space: S,
    seed: u64,
    /// Distinguishes the random streams from those of other predictors for the same sampler.
    group: usize,
    budget: PredictionBudget,
    options: SpectrumOptions,
    /// The energy of degree 0 and the total.
    outline: Energy<S::Bands>,
    energies: BTreeMap<S::Level, Energy<S::Bands>>,
    kurtosis: OnceCell<Option<f64>>,
    on_energies: &'a dyn Fn(usize),
    /// Whether predictions have spectra, or only their band 0.
    has_spectra: bool,
    /// Buffers of the transforms of all predictions.
    workspaces: Workspaces,
}

impl<S: IntegrationSpace> std::fmt::Debug for PredictorOn<'_, S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Predictor")
            .field("space", &self.space)
            .field("seed", &self.seed)
            .field("budget", &self.budget)
            .field("options", &self.options)
            .finish_non_exhaustive()
    }
}

impl<'a, S: IntegrationSpace> PredictorOn<'a, S> {
    pub(crate) fn in_space(
        integrand: S::Integrand<'a>,
        space: S,
        seed: u64,
        budget: PredictionBudget,
    ) -> Result<Self, Error> {
        Ok(Self {
            integrand,
            space,
            seed,
            group: 0,
            budget: budget.checked()?,
            options: SpectrumOptions::default(),
            outline: space.outline(integrand)?,
            energies: BTreeMap::new(),
            kurtosis: OnceCell::new(),
            on_energies: &|_| (),
            has_spectra: true,
            workspaces: Workspaces::default(),
        })
    }

    /// Returns the predictor with the user's settings for spectra.
    #[must_use]
    pub fn with_options(self, options: SpectrumOptions) -> Self {
        Self { options, ..self }
    }

    /// Returns the predictor of predictions without their spectra, which take most of the time on the
    /// square: a [`PredictedPoint::spectrum`] has the bands of the prediction, but only the power of
    /// band 0. Predictions are the same.
    #[must_use]
    pub fn without_spectra(self) -> Self {
        Self { has_spectra: false, ..self }
    }

    /// Returns the predictor with random streams of its own.
    pub(crate) fn with_group(self, group: usize) -> Self {
        Self { group, ..self }
    }

    /// Returns the predictor with a function that is called with the degree before energies are
    /// computed, which may take long.
    #[must_use]
    pub fn on_energies(self, on_energies: &'a dyn Fn(usize)) -> Self {
        Self { on_energies, ..self }
    }

    pub(crate) fn workspaces(&self) -> &Workspaces {
        &self.workspaces
    }

    pub(crate) fn options(&self) -> &SpectrumOptions {
        &self.options
    }

    pub(crate) fn integrand(&self) -> S::Integrand<'a> {
        self.integrand
    }

    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns the kurtosis of the integrand's values, computed once.
    pub(crate) fn kurtosis(&self) -> Option<f64> {
        *self.kurtosis.get_or_init(|| self.space.kurtosis(self.integrand))
    }

    /// Returns the space of the integral.
    #[must_use]
    pub fn space(&self) -> S {
        self.space
    }

    /// Returns the precision and the work of the predictions.
    #[must_use]
    pub fn budget(&self) -> PredictionBudget {
        self.budget
    }

    /// Returns the integrand's energies to the highest degree needed so far, initially 0.
    #[must_use]
    pub fn energy(&self) -> &Energy<S::Bands> {
        self.energies.last_key_value().map_or(&self.outline, |(_, energy)| energy)
    }

    /// Returns the variance that rounding of a prediction alone can produce. The integrand's mean
    /// does not contribute to it.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.outline.prediction_rounding()
    }

    /// Returns the predicted variance for a uniformly rotated sampler. Ticks at most
    /// [`Self::work`].
    ///
    /// Spectra in closed form are used where available
    /// ([`ExactSpectrum`](sphvar_spectrum::ExactSpectrum)). Otherwise realizations are added until
    /// the estimated relative standard error is at most that of the [`PredictionBudget`], within
    /// its work. A pattern that is not random needs one realization. A variance of at most
    /// [`rounding`](Self::rounding) is set to 0.
    ///
    /// # Errors
    ///
    /// Returns [`Error::OtherDomain`] for a sampler of another domain, [`Error::Spectrum`] with the
    /// sampler's error if a realization cannot be generated or `progress` stops the work, and the
    /// errors of [`Integrand::energy`](sphvar_integrands::Integrand::energy).
    pub fn predict(
        &mut self,
        sampler: S::SamplerRef<'_>,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint<S::Bands>, Error> {
        self.predict_within(self.budget, sampler, progress)
    }

    /// Returns [`Self::predict`] with another budget.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`].
    pub fn predict_within(
        &mut self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint<S::Bands>, Error> {
        // One predictor has one point.
        Ok(predict_together(&mut [self], budget, sampler, progress)?.remove(0))
    }

    /// Returns the spectrum to another extent, on the sphere the largest degree, of the same sets
    /// from which `point` was predicted.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`].
    pub fn spectrum_to(
        &self,
        sampler: S::SamplerRef<'_>,
        point: &PredictedPoint<S::Bands>,
        extent: &S::Extent,
    ) -> Result<Spectrum<S::Bands>, Error> {
        let (size, workspaces) = ((S::n_points(sampler), extent), &self.workspaces);
        let sums = |sets: &dyn Ensemble<S::Point>, count: u64| {
            let empty = (self.space.empty_spectrum(size.0, extent)?, Vec::new());
            let options = &self.options;
            let sums = S::accumulate(workspaces, sets, options, size, 0..count, &empty, &())?;
            Ok::<_, Error>(sums.0.finish()?)
        };
        match Route::of::<S>(&self.options, self.budget, sampler, extent) {
            Route::Flat => self.space.flat_spectrum(size.0, extent),
            Route::Exact(exact) => S::exact_spectrum(workspaces, &exact, extent, &()),
            Route::All(sets) => Ok(sums(&sets, sets.len() as u64)?.into_exact()),
            Route::Sampled => {
                let sets = self.realizations(Purpose::Pattern, sampler);
                let spectrum = sums(&sets, point.spectrum.realizations().max(1))?;
                let is_random = S::distribution(sampler).is_random();
                Ok(if is_random { spectrum } else { spectrum.into_exact() })
            }
        }
    }

    /// Computes the integrand's energies that [`Self::predict`] needs for a sampler.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn prepare(&mut self, sampler: S::SamplerRef<'_>) -> Result<(), Error> {
        let extent = self.extent(self.budget, sampler)?;
        match Route::of::<S>(&self.options, self.budget, sampler, &extent) {
            Route::Flat => {}
            Route::Exact(_) | Route::All(_) | Route::Sampled => {
                self.energies_to(&extent)?;
            }
        }
        Ok(())
    }

    /// Returns the number of realizations of the sampler from which a variance is predicted, if that is
    /// the user's choice ([`SpectrumOptions`]) and the sampler is random.
    #[must_use]
    pub fn fixed_realizations(&self, sampler: S::SamplerRef<'_>) -> Option<u64> {
        self.options.realizations.filter(|_| S::distribution(sampler).is_random())
    }

    /// Returns the maximum nominal work of a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn work(&mut self, sampler: S::SamplerRef<'_>) -> Result<f64, Error> {
        self.work_within(self.budget, sampler)
    }

    /// Returns [`Self::work`] for another budget.
    pub(crate) fn work_within(
        &mut self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
    ) -> Result<f64, Error> {
        let extent = self.extent(budget, sampler)?;
        let max = self.max_realizations(budget, sampler, &extent);
        Ok(self.work_to(budget, sampler, &extent, max))
    }

    /// Returns the nominal work of a prediction from a number of realizations, where it needs any.
    pub(crate) fn work_of_realizations(
        &mut self,
        sampler: S::SamplerRef<'_>,
        realizations: u64,
    ) -> Result<f64, Error> {
        let extent = self.extent(self.budget, sampler)?;
        Ok(self.work_to(self.budget, sampler, &extent, realizations))
    }

    fn work_to(
        &self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
        extent: &S::Extent,
        realizations: u64,
    ) -> f64 {
        let transform = S::ticked_work(&self.options, S::n_points(sampler), extent);
        let each = S::nominal_work(sampler) + transform;
        match Route::of::<S>(&self.options, budget, sampler, extent) {
            Route::Flat => 0.0,
            Route::Exact(exact) => S::exact_work(&exact, extent),
            Route::All(sets) => transform * sets.len() as f64,
            Route::Sampled if S::distribution(sampler).is_random() => each * realizations as f64,
            Route::Sampled => each,
        }
    }

    /// Returns whether a prediction is within the work of the [`PredictionBudget`], whatever its
    /// precision.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn is_affordable(&mut self, sampler: S::SamplerRef<'_>) -> Result<bool, Error> {
        self.is_affordable_within(self.budget, sampler)
    }

    /// Returns [`Self::is_affordable`] for another budget.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::is_affordable`].
    pub fn is_affordable_within(
        &mut self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
    ) -> Result<bool, Error> {
        let extent = self.extent(budget, sampler)?;
        let is_random = S::distribution(sampler).is_random();
        let sets = match Route::of::<S>(&self.options, budget, sampler, &extent) {
            Route::Flat => return Ok(true),
            // Closed forms of strata take no longer than realizations.
            Route::Exact(_) if is_random => return Ok(true),
            Route::All(sets) => sets.len() as u64,
            Route::Sampled if is_random => PredictionBudget::MIN_REALIZATIONS,
            Route::Exact(_) | Route::Sampled => 1,
        };
        Ok(sets as f64 * realization_work::<S>(sampler, &extent) <= budget.work)
    }

    /// Returns whether the prediction within a budget is known to be `point`, which was predicted within
    /// another one: from as far a spectrum and as many realizations.
    pub(crate) fn repeats(
        &mut self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
        point: &PredictedPoint<S::Bands>,
    ) -> Result<bool, Error> {
        let extent = self.extent(budget, sampler)?;
        if S::last_band(&extent) != S::last_of(&point.spectrum) {
            return Ok(false);
        }
        let is_random = S::distribution(sampler).is_random();
        let route = Route::of::<S>(&self.options, budget, sampler, &extent);
        Ok(match route {
            Route::Flat | Route::Exact(_) => point.spectrum.realizations() == 0,
            Route::All(sets) => point.spectrum.realizations() == sets.len() as u64,
            Route::Sampled if is_random => {
                let max = self.max_realizations(budget, sampler, &extent);
                let Prediction { variance, stderr, .. } = point.prediction;
                let is_precise = stderr <= budget.relative * variance;
                together::is_last(point.spectrum.realizations(), max, is_precise)
            }
            Route::Sampled => true,
        })
    }

    /// Returns the prediction for power 1 in every degree, from the integrand's mean and mean
    /// square.
    pub(crate) fn flat_prediction(&self, n_points: usize) -> Prediction {
        let of_sum = |errors: &EnergyErrors<_>| errors.of_sum(&[], TailClasses::all(1.0));
        let error = self.outline.errors().map_or(0.0, of_sum);
        let energy_stderr = self.outline.bands().factor(n_points) * error;
        Prediction {
            variance: self.white_variance(n_points),
            stderr: energy_stderr,
            energy_stderr,
            tail: 0.0,
            tail_error: 0.0,
            dof: f64::INFINITY,
        }
    }

    pub(crate) fn max_realizations(
        &self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
        extent: &S::Extent,
    ) -> u64 {
        let affordable = || budget.realizations_of(realization_work::<S>(sampler, extent));
        self.options.realizations.unwrap_or_else(affordable)
    }

    /// Returns the realizations of predictions or of trials.
    pub(crate) fn realizations<'s>(
        &self,
        purpose: Purpose,
        sampler: S::SamplerRef<'s>,
    ) -> S::Realizations<'s> {
        S::realizations(sampler, self.streams(purpose, S::stream_group(sampler)))
    }

    /// Returns the random streams of predictions or of trials of a sampler, given its number.
    pub(crate) fn streams(&self, purpose: Purpose, group: usize) -> Streams {
        Streams::new(self.seed, purpose, group ^ self.group)
    }

    /// Returns how far the spectrum of a sampler is computed.
    pub(crate) fn extent(
        &mut self,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'_>,
    ) -> Result<S::Extent, Error> {
        self.space.check(sampler)?;
        S::extent(self, budget, sampler)
    }

    /// Returns the energies of a level, if they have been computed.
    pub(crate) fn known_energies(&self, level: &S::Level) -> Option<&Energy<S::Bands>> {
        self.energies.get(level)
    }

    /// Returns the energies to an extent or somewhat beyond.
    pub(crate) fn energies_to(&mut self, extent: &S::Extent) -> Result<&Energy<S::Bands>, Error> {
        let energy = match self.energies.entry(S::level(extent)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                place.insert(self.space.energy(self.integrand, extent, self.on_energies)?)
            }
        };
        Ok(energy)
    }
}

/// Returns the nominal work of generating one set and transforming it.
pub(crate) fn realization_work<S: IntegrationSpace>(
    sampler: S::SamplerRef<'_>,
    extent: &S::Extent,
) -> f64 {
    S::nominal_work(sampler).max(0.0) + S::transform_work(S::n_points(sampler), extent)
}
