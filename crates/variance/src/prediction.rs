use sphvar_spectrum::{Accumulator, Moments, Realization, Spectrum};

use crate::Energy;

/// A variance computed from spectra.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The predicted variance of the estimate of the integral.
    pub variance: f64,
    /// Its standard error, from that of the pattern's spectrum.
    pub stderr: f64,
    /// The part of `variance` that belongs to degrees beyond the spectrum, where the pattern's power
    /// is taken to be 1.
    pub tail: f64,
}

/// The variance `k sum_{l >= 1} E(l) <P(l)>` of integrating a function of energies E with a pattern
/// of spectrum P; k is [`Domain::variance_factor`](sphvar_samplers::Domain::variance_factor).
///
/// Degrees beyond the smaller of the two lmax enter with P = 1, the mean power that any pattern
/// tends to. The standard error treats the errors of different degrees as independent;
/// [`PredictionAccumulator`] does without that assumption.
///
/// # Panics
///
/// If spectrum and energy belong to different domains.
#[must_use]
pub fn predict(spectrum: &Spectrum, energy: &Energy) -> Prediction {
    assert_eq!(spectrum.domain(), energy.domain(), "spectra of different domains");
    let weights = Weights::new(energy, spectrum.n_points(), spectrum.lmax());
    let errors = weights.per_degree.iter().zip(spectrum.stderr()).map(|(w, e)| w * e);
    Prediction {
        variance: weights.apply(spectrum.power().iter().copied()) + weights.tail,
        stderr: errors.map(|e| e * e).sum::<f64>().sqrt(),
        tail: weights.tail,
    }
}

/// What one integrand makes of a pattern's power: `sum_l per_degree[l] P(l) + tail`.
#[derive(Clone, Debug)]
struct Weights {
    per_degree: Vec<f64>,
    tail: f64,
}

impl Weights {
    fn new(energy: &Energy, n_points: usize, lmax: usize) -> Self {
        let factor = energy.domain().variance_factor(n_points);
        let lmax = lmax.min(energy.lmax());
        let mut per_degree: Vec<f64> =
            energy.per_degree()[..=lmax].iter().map(|e| factor * e).collect();
        // The number of points is fixed, so the mean has no variance.
        per_degree[0] = 0.0;
        Self { per_degree, tail: factor * energy.beyond(lmax) }
    }

    fn apply(&self, power: impl Iterator<Item = f64>) -> f64 {
        self.per_degree.iter().zip(power).map(|(w, p)| w * p).sum()
    }
}

/// Accumulates the predicted variance realization by realization, so that its standard error knows
/// how the powers of different degrees vary together.
#[derive(Clone, Debug)]
pub struct PredictionAccumulator {
    weights: Weights,
    moments: Moments,
}

impl PredictionAccumulator {
    /// An empty accumulator for an integrand of `energy` and patterns of `n_points` whose spectrum is
    /// computed to `lmax`.
    #[must_use]
    pub fn new(energy: &Energy, n_points: usize, lmax: usize) -> Self {
        Self { weights: Weights::new(energy, n_points, lmax), moments: Moments::default() }
    }

    /// The prediction; its standard error is NaN for a single realization.
    #[must_use]
    pub fn finish(&self) -> Prediction {
        let tail = self.weights.tail;
        let stderr = self.moments.standard_error();
        Prediction { variance: self.moments.mean() + tail, stderr, tail }
    }
}

impl Accumulator for PredictionAccumulator {
    fn push(&mut self, realization: &Realization<'_>) {
        self.moments.push(self.weights.apply(realization.power()));
    }

    fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
    }
}
