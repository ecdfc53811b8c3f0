use rand::Rng;

use crate::{Domain, Error, PointSet, Progress, Sampler, SetDistribution};

/// A sampler built from a pattern; the text of the pattern determines its random streams.
#[derive(Debug)]
pub(crate) struct OfPattern {
    sampler: Box<dyn Sampler>,
    group: usize,
}

impl OfPattern {
    pub(crate) fn new(sampler: Box<dyn Sampler>, group: usize) -> Self {
        Self { sampler, group }
    }
}

impl Sampler for OfPattern {
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
}
