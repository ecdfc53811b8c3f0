use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::{Accumulator, Method, Resolution, Spectrum, SpectrumAccumulator, accumulate};

use crate::{
    Energy, Error, Integrand, PredictedPoint, Prediction, PredictionAccumulator, is_spectrum_known,
    known_spectrum, predict, prediction_degree,
};

/// How precise predictions shall be, and what each may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionBudget {
    /// The relative standard error of a variance at which a prediction is precise enough.
    pub relative: f64,
    /// The seconds of one core that a prediction may take, by a model of the cost and not by a
    /// clock: results do not depend on the machine.
    pub seconds: f64,
}

impl PredictionBudget {
    /// 3 % of the variance, half a second.
    pub const USUAL: Self = Self { relative: 0.03, seconds: 0.5 };
}

/// Realizations that every estimate begins with: fewer say nothing of their error.
const LEAST: u64 = 8;
/// Realizations after which an estimate ends, however cheap they are.
const MOST: u64 = 1 << 14;
/// The share of a lattice's variance that may lie beyond its spectrum, where the power is known in the
/// mean only.
const NEGLIGIBLE: f64 = 0.01;

/// Predicts the variance of integrating one function, for any pattern and number of points.
///
/// It keeps the integrand's energies and computes those of higher degrees when a number of points
/// needs them. A prediction is a function of the seed, the pattern, the number of points and the
/// [`PredictionBudget`]; what was predicted before does not matter.
pub struct Predictor<'a> {
    integrand: &'a dyn Integrand,
    domain: Domain,
    seed: u64,
    budget: PredictionBudget,
    /// To 256, 512, 1024, ... degrees.
    energies: Vec<Energy>,
}

impl std::fmt::Debug for Predictor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Predictor")
            .field("domain", &self.domain)
            .field("seed", &self.seed)
            .field("budget", &self.budget)
            .finish_non_exhaustive()
    }
}

impl<'a> Predictor<'a> {
    /// For an integrand on a domain, with the seed of all realizations.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the integrand does not know its energies, [`Error::Parameter`] for a
    /// precision that is not positive.
    pub fn new(
        integrand: &'a dyn Integrand,
        domain: Domain,
        seed: u64,
        budget: PredictionBudget,
    ) -> Result<Self, Error> {
        for (name, got) in
            [("the relative precision", budget.relative), ("the seconds", budget.seconds)]
        {
            if !(got > 0.0 && got.is_finite()) {
                return Err(Error::Parameter { name, range: "positive and finite", got });
            }
        }
        let mut new = Self { integrand, domain, seed, budget, energies: Vec::new() };
        new.energy_to(0)?.check_magnitude()?;
        Ok(new)
    }

    /// Where the integrand lives.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The integrand's energies to the highest degree that was needed so far, at least 256.
    #[must_use]
    pub fn energy(&self) -> &Energy {
        &self.energies[self.energies.len() - 1]
    }

    /// The variance with white noise of `n_points`: `k sum_{l >= 1} E(l)`, exactly.
    #[must_use]
    pub fn white_variance(&self, n_points: usize) -> f64 {
        self.domain.variance_factor(n_points) * self.energies[0].beyond(0)
    }

    /// Predicts the variance for a pattern of `n_points`. `done` is called after each realization.
    ///
    /// Realizations are added until the relative standard error, as it is estimated from them, is at
    /// most that of the [`PredictionBudget`], but no more than its seconds allow and no fewer than 8. A
    /// pattern that is not random takes one.
    ///
    /// # Errors
    ///
    /// [`Error::Spectrum`] with the sampler's error if the pattern cannot have so many points.
    pub fn predict(
        &mut self,
        pattern: &Pattern,
        n_points: usize,
        done: &(dyn Fn() + Sync),
    ) -> Result<PredictedPoint, Error> {
        let sampler = pattern.build(n_points, self.domain).map_err(sphvar_spectrum::Error::from)?;
        let lmax = self.degree(&*sampler)?;
        let (seed, PredictionBudget { relative, seconds }) = (self.seed, self.budget);
        let domain = self.domain;
        let energy = self.energy_to(lmax)?;
        if let Some(spectrum) =
            known_spectrum(pattern, n_points, domain, lmax, seconds, &|_| done())?
        {
            let prediction = predict(&spectrum, energy);
            return Ok(PredictedPoint { spectrum, prediction });
        }
        let streams = Streams::new(seed, Purpose::Pattern, pattern.stream_group(n_points));
        let sets = Realizations::rotated(&*sampler, streams);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number, and the cast saturates"
        )]
        let most = (seconds / realization_seconds(pattern, n_points, lmax)) as u64;
        let most = most.clamp(LEAST, MOST);
        let (spectrum, prediction) = estimate(&sets, energy, lmax, (relative, most), done)?;
        Ok(PredictedPoint { spectrum, prediction })
    }

    /// Whether a prediction for a pattern of `n_points` takes no more than the seconds of the
    /// [`PredictionBudget`], precise enough or not.
    ///
    /// # Errors
    ///
    /// Those of [`Self::predict`] that show without a realization.
    pub fn is_affordable(&mut self, pattern: &Pattern, n_points: usize) -> Result<bool, Error> {
        let sampler = pattern.build(n_points, self.domain).map_err(sphvar_spectrum::Error::from)?;
        let lmax = self.degree(&*sampler)?;
        if is_spectrum_known(pattern, n_points, self.domain, lmax, self.budget.seconds) {
            return Ok(true);
        }
        let sets = if sampler.is_random() { LEAST as f64 } else { 1.0 };
        Ok(sets * realization_seconds(pattern, n_points, lmax) <= self.budget.seconds)
    }

    /// The degree to which a spectrum is computed: [`prediction_degree`], and for a lattice less where
    /// the integrand has next to no energy beyond.
    fn degree(&mut self, sampler: &dyn Sampler) -> Result<usize, Error> {
        let most = prediction_degree(sampler, self.integrand);
        let least = Resolution::natural_degree(sampler.n_points()).min(most);
        if sampler.is_random() {
            return Ok(most);
        }
        let mut asked = least;
        loop {
            let energy = self.energy_to(asked)?;
            // A lattice has the mean power 1 from some 2 sqrt(N) on: its variance is about this.
            let whole = energy.beyond(least / 2);
            let mut beyond = energy.beyond(least);
            for l in least..=most.min(energy.lmax()) {
                if beyond <= NEGLIGIBLE * whole {
                    return Ok(l);
                }
                beyond -= energy.per_degree().get(l + 1).copied().unwrap_or(0.0);
            }
            asked = degrees_of(level(asked)) + 1;
            if asked > most {
                return Ok(most);
            }
        }
    }

    /// The energies to degree `lmax` or somewhat beyond.
    fn energy_to(&mut self, lmax: usize) -> Result<&Energy, Error> {
        let level = level(lmax);
        // The same steps for everyone: the bits of an environment map's energies depend on lmax.
        while self.energies.len() <= level {
            let degrees = degrees_of(self.energies.len());
            self.energies.push(self.integrand.energy(self.domain, degrees)?);
        }
        Ok(&self.energies[level])
    }
}

/// The largest degree of the energies number `level`.
fn degrees_of(level: usize) -> usize {
    (256_usize << level).min(sphvar_sh::MAX_DEGREE)
}

/// The number of the energies that reach `lmax`; of those to the largest degree there is, beyond.
fn level(lmax: usize) -> usize {
    (0..).find(|&k| degrees_of(k) >= lmax.min(sphvar_sh::MAX_DEGREE)).unwrap_or(0)
}

/// The spectrum and the variance that it predicts, from up to `most` realizations until the variance is
/// known to `relative`.
fn estimate(
    sets: &Realizations<'_>,
    energy: &Energy,
    lmax: usize,
    (relative, most): (f64, u64),
    done: &(dyn Fn() + Sync),
) -> Result<(Spectrum, Prediction), Error> {
    let sampler = sets.sampler();
    let n_points = sampler.n_points();
    let empty = (
        SpectrumAccumulator::new(sampler.domain(), n_points, lmax),
        PredictionAccumulator::new(energy, n_points, lmax),
    );
    let resolution = Resolution::new(lmax, n_points);
    if !sampler.is_random() {
        let (spectrum, prediction) = accumulate(sets, resolution, 0..1, &empty, done)?;
        let exact = Prediction { stderr: 0.0, dof: f64::INFINITY, ..prediction.finish() };
        return Ok((spectrum.finish()?.into_exact(), exact));
    }
    let (mut sum, mut count) = (empty.clone(), 0);
    let mut next = LEAST;
    loop {
        sum.merge(&accumulate(sets, resolution, count..next, &empty, done)?);
        count = next;
        let prediction = sum.1.finish();
        // A pattern without power where the integrand has energy leaves rounding, of 100 % error.
        let rounding = (4.0 * f64::EPSILON).powi(2) * sampler.domain().area() * energy.total();
        let enough =
            prediction.stderr <= relative * prediction.variance || prediction.variance <= rounding;
        if enough || count >= most {
            return Ok((sum.0.finish()?, prediction));
        }
        next = (2 * count).min(most);
    }
}

/// Seconds for making a set and transforming it, roughly.
fn realization_seconds(pattern: &Pattern, n_points: usize, lmax: usize) -> f64 {
    pattern.seconds(n_points) + Method::Auto.seconds(n_points, lmax)
}
