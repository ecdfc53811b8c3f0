use sphvar_integrands::{Energy, EnergyErrors};
use sphvar_sh::{Bands, TailClasses};
use sphvar_spectrum::{ClassMoments, Moments};

/// The errors of energies, which enter a prediction with the mean power of realizations.
#[derive(Clone, Debug)]
pub(crate) struct ErrorTerms<T> {
    errors: EnergyErrors<T>,
    /// The variance of white noise from an energy of 1.
    factor: f64,
}

impl<T: TailClasses> ErrorTerms<T> {
    /// Returns the errors of energies for patterns of `n_points`; `None` if they have none.
    pub(crate) fn new<B: Bands<Tail = T>>(energy: &Energy<B>, n_points: usize) -> Option<Self> {
        Some(Self { errors: energy.errors()?.clone(), factor: energy.bands().factor(n_points) })
    }

    /// Returns the standard error of the variance.
    pub(crate) fn energy_stderr(&self, power: &PowerMoments<T>) -> f64 {
        let powers: Vec<f64> = power.powers.iter().map(Moments::mean).collect();
        self.factor * self.errors.of_sum(&powers, power.beyond.mean())
    }
}

/// The power of realizations, relative to their numbers of points.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: TailClasses")
)]
pub(crate) struct PowerMoments<T> {
    /// Of the power of the bands from 0.
    powers: Vec<Moments>,
    /// Of the power beyond them.
    beyond: ClassMoments<T>,
}

impl<T: TailClasses> PowerMoments<T> {
    /// Returns the empty sums of `n_bands` bands.
    pub(crate) fn new(n_bands: usize) -> Self {
        Self { powers: vec![Moments::default(); n_bands], beyond: ClassMoments::default() }
    }

    /// Adds the power of a realization times `relative`, the number of points per effective one.
    pub(crate) fn push(&mut self, relative: f64, powers: &[f64], tail: T) {
        for (moments, power) in self.powers.iter_mut().zip(powers) {
            moments.push(relative * power);
        }
        self.beyond.push(tail.map(|power| relative * power));
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.powers.iter_mut().zip(&other.powers) {
            mine.merge(theirs);
        }
        self.beyond.merge(&other.beyond);
    }
}
