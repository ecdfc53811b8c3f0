use sphvar_sh::{Bands, Domain};
use sphvar_spectrum::Spectrum;

use crate::{Prediction, VariancePoint};
use sphvar_integrands::Energy;

/// A variance predicted at a number of points.
pub trait PredictedVariance {
    /// Returns the number of points N.
    fn n_points(&self) -> usize;

    /// Returns the predicted variance with its errors.
    fn prediction(&self) -> &Prediction;

    /// Returns the predicted variance as a point of a variance curve.
    fn variance_point(&self) -> VariancePoint {
        let prediction = self.prediction();
        let (variance, stderr) = (prediction.variance, prediction.total_stderr());
        VariancePoint { n_points: self.n_points() as f64, variance, stderr }
    }
}

/// The predicted variance of a pattern at one number of points, with the spectrum that it follows
/// from.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "B: serde::Serialize",
        deserialize = "B: Bands + serde::Deserialize<'de>"
    ))
)]
pub struct PredictedPoint<B: Bands = Domain> {
    /// The mean spectrum of the pattern.
    pub spectrum: Spectrum<B>,
    /// The variance predicted from it.
    pub prediction: Prediction,
}

impl<B: Bands> PredictedPoint<B> {
    /// Returns the number of points N.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.spectrum.n_points()
    }

    /// Returns the predicted standard error of the integral, `sqrt(Var)`.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.prediction.variance.sqrt()
    }

    /// Returns the pattern's mean power over the degrees 1 to `last`, weighted by the integrand's
    /// energy; it is 1 for white noise and NaN where the integrand has no energy.
    #[must_use]
    pub fn power_to(&self, energy: &Energy<B>, last: usize) -> f64 {
        let terms = energy.per_band().iter().zip(self.spectrum.power()).take(last + 1).skip(1);
        let (seen, all) = terms.fold((0.0, 0.0), |(s, a), (e, p)| (s + e * p, a + e));
        seen / all
    }
}

impl<B: Bands> PredictedVariance for PredictedPoint<B> {
    fn n_points(&self) -> usize {
        self.n_points()
    }

    fn prediction(&self) -> &Prediction {
        &self.prediction
    }
}
