mod together;
mod white_noise;

use std::cell::OnceCell;
use std::collections::BTreeMap;

use sphvar_samplers::{Domain, Progress, Purpose, Realizations, Sampler, SetDistribution, Streams};
use sphvar_sh::{ByParity, MAX_DEGREE};
use sphvar_spectrum::{Resolution, Spectrum, SpectrumAccumulator, accumulate};

use crate::energy_levels::{degrees_of, level};
use crate::prediction_budget::realization_work;
use crate::route::Route;
use crate::{
    Error, PredictedPoint, Prediction, PredictionBudget, SpectrumOptions, prediction_degree,
};
use sphvar_integrands::{Energy, EnergyErrors, Integrand};

pub(crate) use self::together::predict as predict_together;
pub(crate) use self::white_noise::ROUNDING;

/// The effective number of degrees, divided by sqrt(N), from which a pattern's mean power is known.
const MIN_BREADTH: f64 = 1.2;
/// The minimum effective number of degrees for few points.
const MIN_EFFECTIVE: f64 = 8.0;
/// The share of a lattice's variance that may lie beyond its spectrum, where only the mean power is
/// known, relative to the square of the budget's precision: 1 % for a precision of 2 %.
const NEGLIGIBLE: f64 = 25.0;

/// Predicts the variance of integrating one function with any sampler. All predictions are made by
/// this type.
///
/// It stores the integrand's energies and computes those of higher degrees when a number of points
/// requires them; white noise requires none. A prediction depends only on the seed, the sampler,
/// the [`PredictionBudget`] and the [`SpectrumOptions`], not on earlier predictions or on the
/// command.
pub struct Predictor<'a> {
    integrand: &'a dyn Integrand,
    domain: Domain,
    seed: u64,
    budget: PredictionBudget,
    options: SpectrumOptions,
    /// The energy of degree 0 and the total.
    outline: Energy,
    /// By level, see [`degrees_of`].
    energies: BTreeMap<usize, Energy>,
    kurtosis: OnceCell<Option<f64>>,
    on_energies: &'a dyn Fn(usize),
}

impl std::fmt::Debug for Predictor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Predictor")
            .field("domain", &self.domain)
            .field("seed", &self.seed)
            .field("budget", &self.budget)
            .field("options", &self.options)
            .finish_non_exhaustive()
    }
}

impl<'a> Predictor<'a> {
    /// Returns a predictor for an integrand on a domain; all realizations use the seed.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Integrand`] if the integrand's energies are unknown, and
    /// [`Error::Parameter`] for a precision that is not positive.
    pub fn new(
        integrand: &'a dyn Integrand,
        domain: Domain,
        seed: u64,
        budget: PredictionBudget,
    ) -> Result<Self, Error> {
        let outline = integrand.energy(domain, 0)?;
        outline.check_magnitude()?;
        Ok(Self {
            integrand,
            domain,
            seed,
            budget: budget.checked()?,
            options: SpectrumOptions::default(),
            outline,
            energies: BTreeMap::new(),
            kurtosis: OnceCell::new(),
            on_energies: &|_| (),
        })
    }

    /// Returns the predictor with the user's settings for spectra.
    #[must_use]
    pub fn with_options(self, options: SpectrumOptions) -> Self {
        Self { options, ..self }
    }

    /// Returns the predictor with a function that is called with the degree before energies are
    /// computed, which may take long.
    #[must_use]
    pub fn on_energies(self, on_energies: &'a dyn Fn(usize)) -> Self {
        Self { on_energies, ..self }
    }

    pub(crate) fn integrand(&self) -> &'a dyn Integrand {
        self.integrand
    }

    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns [`Integrand::kurtosis`], computed once.
    pub(crate) fn kurtosis(&self) -> Option<f64> {
        *self.kurtosis.get_or_init(|| self.integrand.kurtosis(self.domain))
    }

    /// Returns the domain of the integral.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// Returns the precision and the work of the predictions.
    #[must_use]
    pub fn budget(&self) -> PredictionBudget {
        self.budget
    }

    /// Returns the integrand's energies to the highest degree needed so far, initially 0.
    #[must_use]
    pub fn energy(&self) -> &Energy {
        self.energies.last_key_value().map_or(&self.outline, |(_, energy)| energy)
    }

    /// Returns the variance that rounding of a prediction alone can produce. The integrand's mean
    /// does not contribute to it.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.outline.prediction_rounding()
    }

    /// Returns white noise's variance from the degrees beyond `degree`, by parity, or 0 if the
    /// energy there may be concentrated in few degrees.
    ///
    /// The power of a pattern at a single degree is unknown, since any pattern may have a gap
    /// there. The energy beyond `degree`, in at least `max(4 sqrt(N), 32)` degrees, therefore
    /// counts only if the effective number of degrees, `(sum E)^2 / sum E^2`, is at least 1.2
    /// sqrt(N) and 8: the gaps of crystalline patterns are about sqrt(N) wide. The energy of still
    /// higher degrees does not count, since its distribution over degrees is unknown.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Integrand::energy`].
    pub fn broad_variance(&mut self, degree: usize, n_points: usize) -> Result<ByParity, Error> {
        let factor = self.domain.variance_factor(n_points);
        let wide = MIN_BREADTH * self.domain.count_on_sphere(n_points).sqrt();
        let energy = self.energy_to(degree + Resolution::natural_degree(n_points))?;
        let total = energy.centred().sum();
        let (mut sums, mut squares) = (ByParity::both(0.0), 0.0);
        for (l, e) in energy.per_band().iter().enumerate().skip(degree + 1) {
            *sums.of_mut(l) += e;
            // Relative to the total, so that no square overflows or underflows.
            squares += (e / total).powi(2);
        }
        let effective = (sums.sum() / total).powi(2) / squares;
        let is_broad = effective >= wide.max(MIN_EFFECTIVE);
        Ok(if is_broad { sums.map(|sum| factor * sum) } else { ByParity::both(0.0) })
    }

    /// Returns the fraction of white noise's variance that lies beyond a degree.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Integrand::energy`].
    pub fn share_beyond(&mut self, degree: usize) -> Result<f64, Error> {
        let all = self.outline.beyond(0);
        Ok(self.energy_to(degree)?.beyond(degree) / all)
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
    /// errors of [`Integrand::energy`].
    pub fn predict(
        &mut self,
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint, Error> {
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
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint, Error> {
        // One predictor has one point.
        Ok(predict_together(&mut [self], budget, sampler, progress)?.remove(0))
    }

    /// Returns the spectrum to `lmax` of the same sets from which `point` was predicted.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`].
    pub fn spectrum_to(
        &self,
        sampler: &dyn Sampler,
        point: &PredictedPoint,
        lmax: usize,
    ) -> Result<Spectrum, Error> {
        let n_points = sampler.n_points();
        let empty = SpectrumAccumulator::new(self.domain, n_points, lmax);
        let resolution = self.resolution(lmax, n_points);
        let (sums, is_exact) = match Route::of(&self.options, self.budget, sampler, lmax) {
            Route::Flat => {
                return Ok(Spectrum::exact(
                    self.domain,
                    n_points,
                    vec![1.0; lmax.min(MAX_DEGREE) + 1],
                ));
            }
            Route::Exact(exact) => return Ok(exact.to(lmax, &())?),
            Route::All(sets) => {
                let all = 0..sets.len() as u64;
                (accumulate(&sets, resolution, all, &empty, &())?, true)
            }
            Route::Sampled => {
                let count = 0..point.spectrum.realizations().max(1);
                let sets = self.realizations(sampler);
                (accumulate(&sets, resolution, count, &empty, &())?, !sampler.is_random())
            }
        };
        let spectrum = sums.finish()?;
        Ok(if is_exact { spectrum.into_exact() } else { spectrum })
    }

    /// Returns the maximum nominal work of a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn work(&mut self, sampler: &dyn Sampler) -> Result<f64, Error> {
        let lmax = self.degree(self.budget, sampler)?;
        let each =
            sampler.nominal_work() + self.options.method.nominal_work(sampler.n_points(), lmax);
        Ok(match Route::of(&self.options, self.budget, sampler, lmax) {
            Route::Flat => 0.0,
            Route::Exact(exact) => exact.work(lmax),
            Route::All(sets) => {
                let method = self.options.method;
                method.nominal_work(sampler.n_points(), lmax) * sets.len() as f64
            }
            Route::Sampled if sampler.is_random() => {
                each * self.max_realizations(self.budget, sampler, lmax) as f64
            }
            Route::Sampled => each,
        })
    }

    /// Returns whether a prediction is within the work of the [`PredictionBudget`], whatever its
    /// precision.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn is_affordable(&mut self, sampler: &dyn Sampler) -> Result<bool, Error> {
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
        sampler: &dyn Sampler,
    ) -> Result<bool, Error> {
        let lmax = self.degree(budget, sampler)?;
        let sets = match Route::of(&self.options, budget, sampler, lmax) {
            Route::Flat => return Ok(true),
            // Closed forms of strata take no longer than realizations.
            Route::Exact(_) if sampler.is_random() => return Ok(true),
            Route::All(sets) => sets.len() as u64,
            Route::Sampled if sampler.is_random() => PredictionBudget::MIN_REALIZATIONS,
            Route::Exact(_) | Route::Sampled => 1,
        };
        Ok(sets as f64 * realization_work(sampler, lmax) <= budget.work)
    }

    /// Returns the prediction for power 1 in every degree, from the integrand's mean and mean
    /// square.
    fn flat_prediction(&self, n_points: usize) -> Prediction {
        let of_sum = |errors: &EnergyErrors| errors.of_sum(&[], ByParity::both(1.0));
        let error = self.outline.errors().map_or(0.0, of_sum);
        let energy_stderr = self.domain.variance_factor(n_points) * error;
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
        sampler: &dyn Sampler,
        lmax: usize,
    ) -> u64 {
        self.options.realizations.unwrap_or_else(|| budget.realizations(sampler, lmax))
    }

    fn realizations<'s>(&self, sampler: &'s dyn Sampler) -> Realizations<'s> {
        let streams = Streams::new(self.seed, Purpose::Pattern, sampler.stream_group());
        Realizations::rotated(sampler, streams)
    }

    pub(crate) fn resolution(&self, lmax: usize, n_points: usize) -> Resolution {
        let SpectrumOptions { method, epsilon, .. } = self.options;
        Resolution { lmax, n_points, method, epsilon }
    }

    /// Returns the degree to which a spectrum is computed: [`prediction_degree`], or for a lattice
    /// a lower one beyond which the integrand has negligible energy.
    fn degree(&mut self, budget: PredictionBudget, sampler: &dyn Sampler) -> Result<usize, Error> {
        if sampler.domain() != self.domain {
            let (expected, got) = (self.domain, sampler.domain());
            return Err(Error::OtherDomain { expected, got });
        }
        if sampler.n_points() == 0 {
            let reason = "a sampler has no points".to_owned();
            return Err(sphvar_samplers::Error::Given { reason }.into());
        }
        if let SetDistribution::OneOf(sets) = sampler.distribution()
            && let Some(i) = sets.iter().position(|set| set.n_effective() <= 0.0)
        {
            let reason = format!("set {i} has weights whose sum is 0, which estimate no integral");
            return Err(sphvar_samplers::Error::Given { reason }.into());
        }
        let negligible = (NEGLIGIBLE * budget.relative.powi(2)).min(0.1);
        if let Some(lmax) = self.options.lmax {
            return Ok(lmax);
        }
        let max = prediction_degree(sampler, self.integrand);
        let natural = Resolution::natural_degree(sampler.n_points());
        match sampler.distribution() {
            // If there are few given sets, each may be a lattice.
            SetDistribution::OneOf(sets)
                if sets.len() as u64 > budget.realizations(sampler, max) =>
            {
                return Ok(max.min(natural));
            }
            SetDistribution::OneOf(_) | SetDistribution::Fixed => {}
            _ => return Ok(max),
        }
        let min_lmax = natural.min(max);
        let mut requested = min_lmax;
        loop {
            let energy = self.energy_to(requested)?;
            // The mean power of a lattice is 1 from about 2 sqrt(N) on, so this approximates its
            // variance.
            let whole = energy.beyond(min_lmax / 2);
            let mut beyond = energy.beyond(min_lmax);
            for l in min_lmax..=max.min(energy.lmax()) {
                if beyond <= negligible * whole {
                    return Ok(l);
                }
                beyond -= energy.per_band().get(l + 1).copied().unwrap_or(0.0);
            }
            if energy.lmax() >= max.min(MAX_DEGREE) {
                return Ok(max);
            }
            // Estimated energies end at some degree; spectra beyond it are of no use.
            if energy.lmax() < requested {
                return Ok(max.min(energy.lmax().max(min_lmax)));
            }
            // If the energy beyond a degree falls as its inverse square, which is fast, it is
            // negligible here.
            let factor = (beyond / (negligible * whole)).sqrt();
            requested = ahead(energy.lmax(), factor).min(max);
        }
    }

    /// Returns the energies to degree `lmax` or somewhat beyond.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Integrand::energy`].
    pub fn energy_to(&mut self, lmax: usize) -> Result<&Energy, Error> {
        // The steps are fixed because the rounding of an environment map's energies depends on
        // lmax.
        let level = level(lmax);
        if !self.energies.contains_key(&level) {
            let degrees = degrees_of(level);
            (self.on_energies)(degrees);
            self.energies.insert(level, self.integrand.energy(self.domain, degrees)?);
        }
        Ok(&self.energies[&level])
    }
}

/// Returns the degree `factor` times `lmax`, at least the next one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a degree, and the cast saturates"
)]
fn ahead(lmax: usize, factor: f64) -> usize {
    ((lmax as f64 * factor) as usize).max(lmax + 1)
}
