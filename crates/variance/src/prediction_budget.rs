use sphvar_samplers::{Domain, Sampler};
use sphvar_spectrum::{Method, Resolution};

use crate::Error;
use crate::predictor::realization_work;

/// The precision of predictions and the work allowed for each.
///
/// Every criterion that affects a result is a count, never a time, so results are identical on
/// every machine and in every command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionBudget {
    /// The relative standard error of a variance at which a prediction is precise enough.
    pub relative: f64,
    /// The nominal work of all realizations of a prediction, in the unit of
    /// [`Sampler::nominal_work`].
    pub work: f64,
}

impl PredictionBudget {
    /// The default: 2 % of the variance and eight million units, about half a second of one core.
    pub const DEFAULT: Self = Self { relative: 0.02, work: 8e6 };

    /// The minimum number of realizations of an estimate, however expensive they are: with fewer
    /// the error is unknown.
    pub const MIN_REALIZATIONS: u64 = 4;
    /// The maximum number of realizations of an estimate, however inexpensive they are.
    const MAX_REALIZATIONS: u64 = 1 << 14;
    /// The largest number of strata whose spectrum is computed without sampling.
    const MAX_EXACT_STRATA: usize = 4096;

    /// Returns a budget with an eighth of the work and a third of the precision, for points of a
    /// curve that do not affect the answer.
    #[must_use]
    pub fn rough(self) -> Self {
        Self { relative: 3.0 * self.relative, work: self.work / 8.0 }
    }

    /// Checks that both numbers are positive and finite.
    pub(crate) fn checked(self) -> Result<Self, Error> {
        for (name, got) in [("the relative precision", self.relative), ("the work", self.work)] {
            if !(got > 0.0 && got.is_finite()) {
                return Err(Error::Parameter { name, range: "positive and finite", got });
            }
        }
        Ok(self)
    }

    /// Returns the maximum number of realizations from which a spectrum to degree `lmax` is
    /// estimated: the number that the work allows, between 4 and 16384.
    #[must_use]
    pub fn realizations(&self, sampler: &dyn Sampler, lmax: usize) -> u64 {
        self.realizations_of(realization_work::<Domain>(sampler, &lmax))
    }

    /// Returns the maximum number of realizations of a nominal work.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number, and the cast saturates"
    )]
    pub(crate) fn realizations_of(&self, work: f64) -> u64 {
        let affordable = (self.work / work) as u64;
        affordable.clamp(Self::MIN_REALIZATIONS, Self::MAX_REALIZATIONS)
    }

    /// Returns whether the spectrum of a random pattern with a closed form of a nominal work is computed from
    /// it rather than from realizations: within the default budget for up to 4096 strata, within a smaller one
    /// if it takes at most four times its work.
    pub(crate) fn is_exact(&self, n_points: usize, lmax: usize, work: f64) -> bool {
        const MAX_FACTOR: f64 = 4.0;
        n_points <= Self::MAX_EXACT_STRATA
            && lmax <= 2 * Resolution::natural_degree(n_points)
            && (self.work >= Self::DEFAULT.work || work <= MAX_FACTOR * self.work)
    }
}

/// User settings for the spectra behind predictions. By default the [`PredictionBudget`] determines
/// all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumOptions {
    /// The largest degree.
    pub lmax: Option<usize>,
    /// The number of realizations. If it is set, no spectrum of a random pattern is computed in
    /// closed form.
    pub realizations: Option<u64>,
    /// The method of transforming point sets.
    pub method: Method,
    /// The relative accuracy of coefficients from the fast method.
    pub epsilon: f64,
}

impl Default for SpectrumOptions {
    fn default() -> Self {
        Self { lmax: None, realizations: None, method: Method::Auto, epsilon: Resolution::EPSILON }
    }
}

impl SpectrumOptions {
    /// Returns whether the method and accuracy of the transform are the defaults.
    pub(crate) fn is_default_transform(&self) -> bool {
        let Self { method, epsilon, .. } = Self::default();
        self.method == method && self.epsilon.to_bits() == epsilon.to_bits()
    }
}

/// Returns the nominal work of a transform: one unit per point, half a unit per pair of degree and
/// order, and a constant overhead.
pub(crate) fn transform_work(n_points: usize, lmax: usize) -> f64 {
    n_points as f64 + 0.5 * (lmax as f64 + 1.0).powi(2) + 300.0
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern};

    use super::PredictionBudget;

    #[test]
    fn realizations_follow_from_the_work() {
        let budget = PredictionBudget::DEFAULT;
        let count = |name: &str, n, lmax| {
            let sampler = name.parse::<Pattern>().unwrap().build(n, Domain::Sphere).unwrap();
            (budget.realizations(&*sampler, lmax), sampler)
        };
        // 40 + 1 units per point, half of 57^2 for the degrees, and 300: 8e6/9796.5.
        assert_eq!(count("poisson-disk", 192, 56).0, 816);
        assert_eq!(count("white-noise", 12, 32).0, 9211);
        let (few, riesz) = count("riesz", 1 << 20, 1 << 40);
        assert_eq!(few, 4);
        let rich = PredictionBudget { work: 1e300, ..budget };
        assert_eq!(rich.realizations(&*riesz, 4), 1 << 14);
    }
}
