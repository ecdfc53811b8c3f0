use sphvar_samplers::PointSet;

use crate::predictor::realization_work;
use crate::space::{Distribution, IntegrationSpace};
use crate::{PredictionBudget, SpectrumOptions};

/// The method by which a spectrum is computed.
pub(crate) enum Route<'a, P, E> {
    /// The power is 1 in every band.
    Flat,
    /// In closed form or from the fixed points, without sampling.
    Exact(E),
    /// From all the given sets.
    All(&'a [PointSet<P>]),
    /// From realizations.
    Sampled,
}

impl<'a, P, E> Route<'a, P, E> {
    /// Chooses how the spectrum of a sampler is computed.
    pub(crate) fn of<S: IntegrationSpace<Point = P, Exact<'a> = E>>(
        options: &SpectrumOptions,
        budget: PredictionBudget,
        sampler: S::SamplerRef<'a>,
        extent: &S::Extent,
    ) -> Self {
        let is_left_open = options.realizations.is_none();
        match S::distribution(sampler) {
            Distribution::Independent if is_left_open => Self::Flat,
            Distribution::OneOf(sets) => {
                let max = budget.realizations_of(realization_work::<S>(sampler, extent));
                let are_few = is_left_open && sets.len() as u64 <= max;
                if are_few { Self::All(sets) } else { Self::Sampled }
            }
            _ => S::exact(options, budget, sampler, extent).map_or(Self::Sampled, Self::Exact),
        }
    }
}
