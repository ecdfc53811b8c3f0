//! Why a pattern suits an integrand.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::Energy;
use sphvar_variance::Predictor;

use super::candidate::TimedCandidate;
use crate::report::number;

/// The degrees that contribute most of the variance of the integrand, and the power of the pattern
/// there.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Reason {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of points.
    n: usize,
    /// The smallest degree up to which half of white noise's variance lies.
    half_degree: usize,
    /// The pattern's mean power up to this degree, weighted by the integrand's energies; white
    /// noise has 1.
    power_of_half: f64,
    /// The share of the variance with this pattern that these degrees contribute.
    share_of_half: f64,
}

impl Reason {
    /// Returns the reason for a pattern with a prediction at its number of points or at the largest
    /// one tried, or `None` if half of the energy lies beyond the computed degrees.
    pub(super) fn new(candidate: &TimedCandidate, predictor: &Predictor<'_>) -> Option<Self> {
        let at = candidate.answer.n_points.and_then(|n| candidate.answer.curve.at(n));
        let point = at.or(candidate.answer.curve.points().last())?;
        let energy = predictor.energy();
        let last = half_degree(energy)?;
        let power = point.power_to(energy, last);
        let low: f64 = energy.per_band()[1..=last].iter().sum();
        let factor = energy.domain().variance_factor(point.n_points());
        (last <= point.spectrum.lmax() && power.is_finite()).then(|| Self {
            sampler: candidate.answer.curve.pattern().to_string(),
            n: point.n_points(),
            half_degree: last,
            power_of_half: power,
            share_of_half: factor * low * power / point.prediction.variance,
        })
    }

    pub(super) fn sentence(&self, name: &str) -> String {
        let degrees = match self.half_degree {
            1 => "degree 1".to_owned(),
            l => format!("degrees <= {l}"),
        };
        let power = match self.power_of_half {
            p if p < 1e-20 => "no power".to_owned(),
            p => format!("power {}", number::ratio(p)),
        };
        let n = self.n;
        format!(
            "half of the integrand's variance under white noise is in {degrees}, where {name} has \
             {power} at N = {n} (white noise 1)"
        )
    }
}

/// Returns the smallest degree up to which half of the energy beyond degree 0 lies, if the energy
/// is known that far.
fn half_degree(energy: &Energy) -> Option<usize> {
    let half = 0.5 * energy.beyond(0);
    let mut sum = 0.0;
    let mut degrees = energy.per_band().iter().enumerate().skip(1);
    degrees
        .find(|(_, e)| {
            sum += **e;
            sum >= half && half > 0.0
        })
        .map(|(l, _)| l)
}
