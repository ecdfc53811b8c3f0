use rand::Rng;

use crate::{
    Domain, Error, PointSet, Progress, Sampler, SetDistribution, SquareDistribution, SquareSampler,
};

/// A sampler built from a pattern; the text of the pattern determines its random streams.
#[derive(Debug)]
pub(crate) struct OfPattern<S: ?Sized> {
    pub(crate) sampler: Box<S>,
    pub(crate) group: usize,
    pub(crate) sequence_group: Option<usize>,
}

impl<S: ?Sized> OfPattern<S> {
    pub(crate) fn new(sampler: Box<S>, group: usize, sequence_group: Option<usize>) -> Self {
        Self { sampler, group, sequence_group }
    }
}

impl Sampler for OfPattern<dyn Sampler> {
    fn n_points(&self) -> usize {
        self.sampler.n_points()
    }

    fn domain(&self) -> Domain {
        self.sampler.domain()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sampler.sample_into(rng, set)
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_watched(rng, set, progress)
    }

    fn distribution(&self) -> SetDistribution<'_> {
        self.sampler.distribution()
    }

    fn last_empty_degree(&self) -> Option<usize> {
        self.sampler.last_empty_degree()
    }

    fn nominal_work(&self) -> f64 {
        self.sampler.nominal_work()
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group
    }
}

impl SquareSampler for OfPattern<dyn SquareSampler> {
    fn n_points(&self) -> usize {
        self.sampler.n_points()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sampler.sample_into(rng, set)
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_watched(rng, set, progress)
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        self.sampler.distribution()
    }

    fn nominal_work(&self) -> f64 {
        self.sampler.nominal_work()
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group
    }
}
