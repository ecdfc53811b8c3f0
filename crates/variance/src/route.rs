use sphvar_samplers::{PointSet, Sampler, SetDistribution};
use sphvar_spectrum::ExactSpectrum;

use crate::{PredictionBudget, SpectrumOptions};

/// The method by which a spectrum is computed.
pub(crate) enum Route<'a> {
    /// The power is 1 in every degree.
    Flat,
    /// In closed form or from the fixed points, without sampling.
    Exact(ExactSpectrum<'a>),
    /// From all the given sets.
    All(&'a [PointSet]),
    /// From realizations.
    Sampled,
}

impl<'a> Route<'a> {
    /// Chooses how the spectrum of a sampler is computed.
    pub(crate) fn of(
        options: &SpectrumOptions,
        budget: PredictionBudget,
        sampler: &'a dyn Sampler,
        lmax: usize,
    ) -> Self {
        let is_left_open = options.realizations.is_none();
        match sampler.distribution() {
            SetDistribution::Independent if is_left_open => Self::Flat,
            SetDistribution::OneOf(sets) if sets.len() > 1 => {
                let max = budget.realizations(sampler, lmax);
                let are_few = is_left_open && sets.len() as u64 <= max;
                if are_few { Self::All(sets) } else { Self::Sampled }
            }
            kind => {
                let is_chosen = if kind.is_random() {
                    is_left_open && PredictionBudget::is_exact(sampler.n_points(), lmax)
                } else {
                    options.is_default_transform()
                };
                let exact = ExactSpectrum::of(sampler).filter(|_| is_chosen);
                exact.map_or(Self::Sampled, Self::Exact)
            }
        }
    }
}
