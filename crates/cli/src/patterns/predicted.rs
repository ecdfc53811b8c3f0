//! Patterns whose variances are predicted.

use sphvar_samplers::{
    Domain, Pattern, Sampler, SetDistribution, SquareDistribution, SquarePattern, SquareSampler,
};
use sphvar_sh::{Bands, Frequencies};
use sphvar_spectrum::Spectrum;
use sphvar_variance::IntegrationSpace;

use super::PatternKind;

/// A pattern of any space whose variances are predicted and measured.
pub(crate) trait PredictedPattern:
    PatternKind<Space: IntegrationSpace<Sampler = Self::Sampler, Bands = Self::Bands>>
    + Clone
    + PartialEq
{
    /// The bands of its spectra.
    type Bands: Bands;
    /// Its samplers.
    type Sampler: ?Sized;

    /// Returns whether a set has weights, of which the effective number of points is known.
    fn has_weights(sampler: SamplerRef<'_, Self>, n_effective: f64) -> bool;
}

/// A reference to a sampler of a pattern.
pub(crate) type SamplerRef<'a, P> = <<P as PatternKind>::Space as IntegrationSpace>::SamplerRef<'a>;
/// The bands of the spectra of a pattern.
pub(crate) type BandsOf<P> = <P as PredictedPattern>::Bands;

impl PredictedPattern for Pattern {
    type Bands = Domain;
    type Sampler = dyn Sampler;

    fn has_weights(sampler: &dyn Sampler, n_effective: f64) -> bool {
        match sampler.distribution() {
            SetDistribution::OneOf(sets) => sets.iter().any(|set| !set.weights.is_empty()),
            // Rules with equal weights have none.
            SetDistribution::Fixed => (n_effective / sampler.n_points() as f64 - 1.0).abs() > 1e-9,
            _ => false,
        }
    }
}

impl PredictedPattern for SquarePattern {
    type Bands = Frequencies;
    type Sampler = dyn SquareSampler;

    fn has_weights(sampler: &dyn SquareSampler, _: f64) -> bool {
        match sampler.distribution() {
            SquareDistribution::OneOf(sets) => sets.iter().any(|set| !set.weights.is_empty()),
            // Only the sets of files have weights.
            _ => false,
        }
    }
}

/// Returns the effective number of points of a sampler's spectrum, or `None` if its sets have no
/// weights.
pub(crate) fn n_effective<P: PredictedPattern>(
    sampler: SamplerRef<'_, P>,
    spectrum: &Spectrum<BandsOf<P>>,
) -> Option<f64> {
    let effective = spectrum.n_effective();
    P::has_weights(sampler, effective).then_some(effective)
}
