use std::cell::OnceCell;
use std::collections::BTreeMap;

use sphvar_samplers::{Domain, Law, Progress, Purpose, Realizations, Sampler, Streams};
use sphvar_sh::{ByParity, LmIndex, MAX_DEGREE};
use sphvar_spectrum::{Accumulator, Resolution, Spectrum, SpectrumAccumulator, accumulate};

use crate::energy_levels::{degrees_of, level};
use crate::prediction_budget::realization_work;
use crate::route::Route;
use crate::{
    Error, PredictedPoint, Prediction, PredictionAccumulator, PredictionBudget, SpectrumOptions,
    predict, prediction_degree,
};
use sphvar_integrands::{Energy, Integrand};

/// Realizations that an estimate begins with, if the budget allows as many.
const FIRST: u64 = 8;
/// The effective number of degrees over sqrt(N) from which on a pattern's mean power there is known.
const MIN_BREADTH: f64 = 1.2;
/// The effective number of degrees at least, however few the points.
const MIN_EFFECTIVE: f64 = 8.0;
/// The share of a lattice's variance that may lie beyond its spectrum, where the power is known in the
/// mean only, relative to the square of the budget's precision: 1 % where that is 2 %.
const NEGLIGIBLE: f64 = 25.0;

/// Predicts the variance of integrating one function with any sampler; all predictions are made by
/// it.
///
/// It keeps the integrand's energies and computes those of higher degrees when a number of points
/// needs them; white noise needs none. A prediction is a function of the seed, the sampler, the
/// [`PredictionBudget`] and the [`SpectrumOptions`]; what was predicted before, and by
/// which command, does not matter.
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
    /// For an integrand on a domain, with the seed of all realizations.
    ///
    /// # Errors
    ///
    /// [`Error::Integrand`] if the integrand does not know its energies, [`Error::Parameter`] for a
    /// precision that is not positive.
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

    /// The same with spectra as the user fixes them.
    #[must_use]
    pub fn with_options(self, options: SpectrumOptions) -> Self {
        Self { options, ..self }
    }

    /// The same, with a function that is called with the degree before energies are computed, which
    /// may take long.
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

    /// [`Integrand::kurtosis`], asked for once.
    pub(crate) fn kurtosis(&self) -> Option<f64> {
        *self.kurtosis.get_or_init(|| self.integrand.kurtosis(self.domain))
    }

    /// Where the integrand lives.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The precision and work of its predictions.
    #[must_use]
    pub fn budget(&self) -> PredictionBudget {
        self.budget
    }

    /// The integrand's energies to the highest degree that was needed so far, which is 0 at first.
    #[must_use]
    pub fn energy(&self) -> &Energy {
        self.energies.last_key_value().map_or(&self.outline, |(_, energy)| energy)
    }

    /// The variance with white noise of `n_points`: `k sum_{l >= 1} E(l)`, exactly.
    #[must_use]
    pub fn white_variance(&self, n_points: usize) -> f64 {
        self.domain.variance_factor(n_points) * self.outline.beyond(0)
    }

    /// The variance that the rounding of a prediction alone can make, in which the integrand's mean has no part.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.outline.prediction_rounding()
    }

    /// Returns white noise's variance of the degrees beyond `degree` that are known to be many, by
    /// parity; 0 where the energy may be concentrated in a few degrees.
    ///
    /// A single degree says nothing of a pattern: any may have a gap in its power there. The degrees
    /// beyond `degree`, `max(4 sqrt(N), 32)` of them at least, count only where their effective number,
    /// `(sum E)^2 / sum E^2`, is at least 1.2 sqrt(N) and 8: the gaps of crystalline patterns are about
    /// sqrt(N) wide. Energy of higher degrees does not count, since its degrees are not known.
    ///
    /// # Errors
    ///
    /// Those of [`Integrand::energy`].
    pub fn broad_variance(&mut self, degree: usize, n_points: usize) -> Result<ByParity, Error> {
        let factor = self.domain.variance_factor(n_points);
        let wide = MIN_BREADTH * self.domain.count_on_sphere(n_points).sqrt();
        let energy = self.energy_to(degree + Resolution::natural_degree(n_points))?;
        let total = energy.centred().sum();
        let (mut sums, mut squares) = (ByParity::both(0.0), 0.0);
        for (l, e) in energy.per_band().iter().enumerate().skip(degree + 1) {
            *sums.of_mut(l) += e;
            // Relative to the total, so that no square leaves the range of numbers.
            squares += (e / total).powi(2);
        }
        let effective = (sums.sum() / total).powi(2) / squares;
        let is_broad = effective >= wide.max(MIN_EFFECTIVE);
        Ok(if is_broad { sums.map(|sum| factor * sum) } else { ByParity::both(0.0) })
    }

    /// The share of white noise's variance that lies beyond a degree.
    ///
    /// # Errors
    ///
    /// Those of [`Integrand::energy`].
    pub fn share_beyond(&mut self, degree: usize) -> Result<f64, Error> {
        let all = self.outline.beyond(0);
        Ok(self.energy_to(degree)?.beyond(degree) / all)
    }

    /// Predicts the variance for a sampler, uniformly rotated. At most [`Self::work`] is ticked.
    ///
    /// Spectra that are known without sampling are taken where there are any
    /// ([`ExactSpectrum`](sphvar_spectrum::ExactSpectrum)); else realizations are added until the relative
    /// standard error, as it is estimated from them, is at most that of the [`PredictionBudget`], but no
    /// more than its work allows. A pattern that is not random takes one.
    /// A variance that is no more than [`rounding`](Self::rounding) is 0.
    ///
    /// # Errors
    ///
    /// [`Error::OtherDomain`] for a sampler of another domain, [`Error::Spectrum`] with the sampler's error if a
    /// realization cannot be made or `progress` ends the work, and those of [`Integrand::energy`].
    pub fn predict(
        &mut self,
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint, Error> {
        self.predict_within(self.budget, sampler, progress)
    }

    /// [`Self::predict`] with another budget.
    ///
    /// # Errors
    ///
    /// Those of [`Self::predict`].
    pub fn predict_within(
        &mut self,
        budget: PredictionBudget,
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint, Error> {
        let lmax = self.degree(budget, sampler)?;
        let n_points = sampler.n_points();
        let mut point = match Route::of(&self.options, budget, sampler, lmax) {
            Route::Flat => {
                let power = vec![1.0; lmax.min(MAX_DEGREE) + 1];
                let spectrum = Spectrum::exact(self.domain, n_points, power);
                PredictedPoint { spectrum, prediction: self.flat_prediction(n_points) }
            }
            Route::Exact(exact) => {
                let spectrum = exact.to(lmax, progress)?;
                let prediction = predict(&spectrum, self.energy_to(lmax)?);
                PredictedPoint { spectrum, prediction }
            }
            Route::All(sets) => {
                let all = 0..sets.len() as u64;
                let empty = self.accumulators(sampler, lmax)?;
                let resolution = self.resolution(lmax, n_points);
                let sums = accumulate(&sets, resolution, all, &empty, progress)?;
                exactly(sums)?
            }
            Route::Sampled => self.estimate(budget, sampler, lmax, progress)?,
        };
        if point.prediction.variance <= self.rounding() {
            let Prediction { variance, stderr, .. } = &mut point.prediction;
            (*variance, *stderr) = (0.0, 0.0);
        }
        Ok(point)
    }

    /// The spectrum to `lmax` of the very sets that `point` was predicted from.
    ///
    /// # Errors
    ///
    /// Those of [`Self::predict`].
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
    /// Those of [`Self::predict`] that show without a realization.
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
                each * self.most_realizations(self.budget, sampler, lmax) as f64
            }
            Route::Sampled => each,
        })
    }

    /// Whether a prediction takes no more than the work of the [`PredictionBudget`], precise enough or not.
    ///
    /// # Errors
    ///
    /// Those of [`Self::predict`] that show without a realization.
    pub fn is_affordable(&mut self, sampler: &dyn Sampler) -> Result<bool, Error> {
        self.is_affordable_within(self.budget, sampler)
    }

    /// [`Self::is_affordable`] with another budget.
    ///
    /// # Errors
    ///
    /// Those of [`Self::is_affordable`].
    pub fn is_affordable_within(
        &mut self,
        budget: PredictionBudget,
        sampler: &dyn Sampler,
    ) -> Result<bool, Error> {
        let lmax = self.degree(budget, sampler)?;
        let sets = match Route::of(&self.options, budget, sampler, lmax) {
            Route::Flat => return Ok(true),
            // Closed forms of strata take no longer than realizations would.
            Route::Exact(_) if sampler.is_random() => return Ok(true),
            Route::All(sets) => sets.len() as u64,
            Route::Sampled if sampler.is_random() => PredictionBudget::MIN_REALIZATIONS,
            Route::Exact(_) | Route::Sampled => 1,
        };
        Ok(sets as f64 * realization_work(sampler, lmax) <= budget.work)
    }

    /// The power per degree is 1: the variance follows from the integrand's mean and mean square.
    fn flat_prediction(&self, n_points: usize) -> Prediction {
        Prediction {
            variance: self.white_variance(n_points),
            stderr: 0.0,
            tail: 0.0,
            tail_error: 0.0,
            dof: f64::INFINITY,
        }
    }

    /// The spectrum and the variance that it predicts, from realizations.
    fn estimate(
        &mut self,
        budget: PredictionBudget,
        sampler: &dyn Sampler,
        lmax: usize,
        progress: &dyn Progress,
    ) -> Result<PredictedPoint, Error> {
        let (relative, rounding) = (budget.relative, self.rounding());
        let most = self.most_realizations(budget, sampler, lmax);
        let first = self.options.realizations.unwrap_or(FIRST.min(most));
        let resolution = self.resolution(lmax, sampler.n_points());
        let empty = self.accumulators(sampler, lmax)?;
        let sets = self.realizations(sampler);
        if !sampler.is_random() {
            return exactly(accumulate(&sets, resolution, 0..1, &empty, progress)?);
        }
        let (mut sum, mut count, mut next) = (empty.clone(), 0, first);
        loop {
            sum.merge(&accumulate(&sets, resolution, count..next, &empty, progress)?);
            count = next;
            let prediction = sum.1.finish();
            // A pattern without power where the integrand has energy leaves rounding, of 100 % error.
            let enough = prediction.stderr <= relative * prediction.variance
                || prediction.variance <= rounding;
            if enough || count >= most {
                return Ok(PredictedPoint { spectrum: sum.0.finish()?, prediction });
            }
            next = (2 * count).min(most);
        }
    }

    fn most_realizations(
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

    fn accumulators(
        &mut self,
        sampler: &dyn Sampler,
        lmax: usize,
    ) -> Result<(SpectrumAccumulator, PredictionAccumulator), Error> {
        let n_points = sampler.n_points();
        // Degrees that have no transforms need no memory either.
        LmIndex::new(lmax).map_err(sphvar_spectrum::Error::from)?;
        let spectrum = SpectrumAccumulator::new(self.domain, n_points, lmax);
        Ok((spectrum, PredictionAccumulator::new(self.energy_to(lmax)?, n_points, lmax)))
    }

    fn resolution(&self, lmax: usize, n_points: usize) -> Resolution {
        let SpectrumOptions { method, epsilon, .. } = self.options;
        Resolution { lmax, n_points, method, epsilon }
    }

    /// The degree to which a spectrum is computed: [`prediction_degree`], and for a lattice less where
    /// the integrand has next to no energy beyond.
    fn degree(&mut self, budget: PredictionBudget, sampler: &dyn Sampler) -> Result<usize, Error> {
        if sampler.domain() != self.domain {
            let (expected, got) = (self.domain, sampler.domain());
            return Err(Error::OtherDomain { expected, got });
        }
        if sampler.n_points() == 0 {
            let reason = "a sampler has no points".to_owned();
            return Err(sphvar_samplers::Error::Given { reason }.into());
        }
        if let Law::OneOf(sets) = sampler.law()
            && let Some(i) = sets.iter().position(|set| set.n_effective() <= 0.0)
        {
            let reason = format!("set {i} has weights whose sum is 0, which estimate no integral");
            return Err(sphvar_samplers::Error::Given { reason }.into());
        }
        let negligible = (NEGLIGIBLE * budget.relative.powi(2)).min(0.1);
        if let Some(lmax) = self.options.lmax {
            return Ok(lmax);
        }
        let most = prediction_degree(sampler, self.integrand);
        let natural = Resolution::natural_degree(sampler.n_points());
        match sampler.law() {
            // Each of few given sets may be a lattice.
            Law::OneOf(sets) if sets.len() as u64 > budget.realizations(sampler, most) => {
                return Ok(most.min(natural));
            }
            Law::OneOf(_) | Law::Fixed => {}
            _ => return Ok(most),
        }
        let least = natural.min(most);
        let mut asked = least;
        loop {
            let energy = self.energy_to(asked)?;
            // A lattice has the mean power 1 from some 2 sqrt(N) on: its variance is about this.
            let whole = energy.beyond(least / 2);
            let mut beyond = energy.beyond(least);
            for l in least..=most.min(energy.lmax()) {
                if beyond <= negligible * whole {
                    return Ok(l);
                }
                beyond -= energy.per_band().get(l + 1).copied().unwrap_or(0.0);
            }
            if energy.lmax() >= most.min(MAX_DEGREE) {
                return Ok(most);
            }
            // Energy beyond a degree that falls as its square, which is fast, is negligible here.
            let factor = (beyond / (negligible * whole)).sqrt();
            asked = ahead(energy.lmax(), factor).min(most);
        }
    }

    /// Returns the energies to degree `lmax` or somewhat beyond.
    ///
    /// # Errors
    ///
    /// Those of [`Integrand::energy`].
    pub fn energy_to(&mut self, lmax: usize) -> Result<&Energy, Error> {
        // The same steps for everyone: the bits of an environment map's energies depend on lmax.
        let level = level(lmax);
        if !self.energies.contains_key(&level) {
            let degrees = degrees_of(level);
            (self.on_energies)(degrees);
            self.energies.insert(level, self.integrand.energy(self.domain, degrees)?);
        }
        Ok(&self.energies[&level])
    }
}

/// The prediction from sums over all sets, which is exact.
fn exactly(
    (spectrum, prediction): (SpectrumAccumulator, PredictionAccumulator),
) -> Result<PredictedPoint, Error> {
    let prediction = Prediction { stderr: 0.0, dof: f64::INFINITY, ..prediction.finish() };
    Ok(PredictedPoint { spectrum: spectrum.finish()?.into_exact(), prediction })
}

/// The degree `factor` times `lmax`, at least the next one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a degree, and the cast saturates"
)]
fn ahead(lmax: usize, factor: f64) -> usize {
    ((lmax as f64 * factor) as usize).max(lmax + 1)
}
