//! Predictions on the sphere and the hemisphere.

use std::ops::Range;

use sphvar_samplers::{Domain, Progress, Purpose, Sampler, SetDistribution};
use sphvar_sh::{ByParity, MAX_DEGREE};
use sphvar_spectrum::{Resolution, SpectrumAccumulator};

use super::Predictor;
use crate::degree::degree_limit;
use crate::space::IntegrationSpace;
use crate::{Error, PredictionBudget, SpectrumOptions, prediction_degree};
use sphvar_integrands::{Energy, Integrand};

/// The effective number of degrees, divided by sqrt(N), from which a pattern's mean power is known.
const MIN_BREADTH: f64 = 1.2;
/// The minimum effective number of degrees for few points.
const MIN_EFFECTIVE: f64 = 8.0;
/// The share of a lattice's variance that may lie beyond its spectrum, where only the mean power is
/// known, relative to the square of the budget's precision: 1 % for a precision of 2 %.
const NEGLIGIBLE: f64 = 25.0;
/// The same share for any budget. Half of the variance of a jump lies beyond the degree from which
/// the mean power of a lattice is 1, where spectra end at the earliest; the error of the tail tells
/// how much that leaves unknown.
const MAX_NEGLIGIBLE: f64 = 0.5;

/// Returns the share of a lattice's variance that may lie beyond its spectrum.
pub(crate) fn negligible(budget: PredictionBudget) -> f64 {
    (NEGLIGIBLE * budget.relative.powi(2)).min(MAX_NEGLIGIBLE)
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
        Self::in_space(integrand, domain, seed, budget)
    }

    /// Returns the degree to which the spectrum of a sampler is computed for a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn spectrum_degree(&mut self, sampler: &dyn Sampler) -> Result<usize, Error> {
        self.extent(self.budget(), sampler)
    }

    /// Returns the sums of the spectrum to degree `lmax` over some of the realizations of a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`].
    pub fn spectrum_sums(
        &self,
        sampler: &dyn Sampler,
        lmax: usize,
        realizations: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<SpectrumAccumulator, Error> {
        let sets = self.realizations(Purpose::Pattern, sampler);
        let n_points = sampler.n_points();
        let empty = (self.space().empty_spectrum(n_points, &lmax)?, Vec::new());
        let size = (n_points, &lmax);
        let (options, workspaces) = (self.options(), self.workspaces());
        let sums =
            Domain::accumulate(workspaces, &sets, options, size, realizations, &empty, progress)?;
        Ok(sums.0)
    }

    /// Returns the domain of the integral.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.space
    }

    /// Returns the energies to degree `lmax` or somewhat beyond.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Integrand::energy`].
    pub fn energy_to(&mut self, lmax: usize) -> Result<&Energy, Error> {
        self.energies_to(&lmax)
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
        let factor = self.space.variance_factor(n_points);
        let wide = MIN_BREADTH * self.space.count_on_sphere(n_points).sqrt();
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

    pub(crate) fn resolution(&self, lmax: usize, n_points: usize) -> Resolution {
        let SpectrumOptions { method, epsilon, .. } = self.options;
        Resolution { lmax, n_points, method, epsilon }
    }

    /// Returns the degree to which a spectrum is computed: [`prediction_degree`], or for a lattice
    /// a lower one beyond which the integrand has negligible energy.
    pub(crate) fn degree(
        &mut self,
        budget: PredictionBudget,
        sampler: &dyn Sampler,
    ) -> Result<usize, Error> {
        let negligible = negligible(budget);
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
        self.negligible_degree(negligible, [natural.min(max), max])
    }

    /// Returns the degree to which the kernel of pairs is computed for the prefixes of sets: that of
    /// spectra of lattices, since the cost of the kernel does not depend on it.
    pub(crate) fn prefix_degree(&mut self, sampler: &dyn Sampler) -> Result<usize, Error> {
        if let Some(lmax) = self.options.lmax {
            return Ok(lmax);
        }
        let max = degree_limit(sampler.n_points(), sampler.domain(), self.integrand, true);
        let natural = Resolution::natural_degree(sampler.n_points());
        self.negligible_degree(negligible(self.budget), [natural.min(max), max])
    }

    /// Returns the lowest degree within `[min, max]` beyond which the integrand has a negligible
    /// share of its energy from half of `min` on.
    fn negligible_degree(
        &mut self,
        negligible: f64,
        [min_lmax, max]: [usize; 2],
    ) -> Result<usize, Error> {
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
