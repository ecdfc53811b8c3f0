//! Why a pattern suits an integrand.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::Energy;
use sphvar_sh::Bands;
use sphvar_variance::{IntegrationSpace, PredictedPoint, PredictorOn};

use crate::commands::power_chart::{ShownBands, largest_radius, radius, whole};
use crate::report::number;

/// The degrees that contribute most of the variance of the integrand, and the power of the pattern
/// there.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct Reason {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of points.
    n: usize,
    /// The bands in which half of white noise's variance lies.
    #[serde(skip)]
    range: String,
    /// The smallest degree up to which half of white noise's variance lies; on the square the
    /// largest frequency, rounded up.
    half_degree: usize,
    /// The pattern's mean power up to this degree, weighted by the integrand's energies; white
    /// noise has 1.
    power_of_half: f64,
    /// The share of the variance with this pattern that these degrees contribute.
    share_of_half: f64,
}

impl Reason {
    /// Returns the reason for a prediction of a pattern, or `None` if half of the energy lies beyond
    /// the computed degrees.
    pub(super) fn new<S: IntegrationSpace<Bands: ShownBands>>(
        sampler: String,
        point: &PredictedPoint<S::Bands>,
        predictor: &PredictorOn<'_, S>,
    ) -> Option<Self> {
        let energy = predictor.energy();
        let last = half_degree(energy)?;
        let power = point.power_to(energy, last);
        let low: f64 = energy.per_band()[1..=last].iter().sum();
        let factor = energy.bands().factor(point.n_points());
        // Up to this radius the bands of both are the same.
        let common = largest_radius(&point.spectrum).min(radius(energy.bands(), energy.lmax()));
        let radius = energy.bands().radius(last);
        (radius <= common as f64 && power.is_finite()).then(|| Self {
            sampler,
            n: point.n_points(),
            range: S::Bands::range(radius),
            half_degree: whole(radius),
            power_of_half: power,
            share_of_half: factor * low * power / point.prediction.variance,
        })
    }

    pub(super) fn sentence(&self, name: &str) -> String {
        let power = match self.power_of_half {
            p if p < 1e-20 => "no power".to_owned(),
            p => format!("power {}", number::ratio(p)),
        };
        let Self { n, range, .. } = self;
        format!(
            "half of the integrand's variance under white noise is in {range}, where {name} has \
             {power} at N = {n} (white noise 1)"
        )
    }
}

/// Returns the smallest band up to which half of the energy beyond band 0 lies, if the energy
/// is known that far.
fn half_degree<B: Bands>(energy: &Energy<B>) -> Option<usize> {
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
