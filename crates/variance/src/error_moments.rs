use sphvar_integrands::{Energy, EnergyErrors};
use sphvar_sh::{Bands, TailClasses};
use sphvar_spectrum::{ClassMoments, Moments};

/// The mean power of realizations, with which the errors of energies enter a prediction.
#[derive(Clone, Debug)]
pub(crate) struct ErrorMoments<T> {
    errors: EnergyErrors<T>,
    /// The variance of white noise from an energy of 1.
    factor: f64,
    /// Of the power of the bands from 0.
    powers: Vec<Moments>,
    /// Of the power beyond them.
    beyond: ClassMoments<T>,
}

impl<T: TailClasses> ErrorMoments<T> {
    /// Returns the empty sums of `n_bands` bands; `None` if the energies have no errors.
    pub(crate) fn new<B: Bands<Tail = T>>(
        energy: &Energy<B>,
        n_points: usize,
        n_bands: usize,
    ) -> Option<Self> {
        Some(Self {
            errors: energy.errors()?.clone(),
            factor: energy.bands().factor(n_points),
            powers: vec![Moments::default(); n_bands],
            beyond: ClassMoments::default(),
        })
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

    /// Returns the standard error of the variance.
    pub(crate) fn energy_stderr(&self) -> f64 {
        let powers: Vec<f64> = self.powers.iter().map(Moments::mean).collect();
        self.factor * self.errors.of_sum(&powers, self.beyond.mean())
    }
}
