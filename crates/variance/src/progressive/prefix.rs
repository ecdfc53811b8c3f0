//! The first points of the sets of a sampler.

use rand::Rng;
use sphvar_samplers::{
    Domain, Error, Point, PointSet, Progress, Sampler, SetDistribution, SquareDistribution,
    SquareSampler,
};

/// The sampler of the first points of each set of another one.
#[derive(Debug)]
pub(super) struct Prefix<'s, S: ?Sized, P> {
    pub(super) sampler: &'s S,
    pub(super) n_points: usize,
    /// The number of the random streams, which all prefixes share.
    pub(super) group: usize,
    /// The first points of the given sets.
    pub(super) sets: Vec<PointSet<P>>,
}

/// Returns the first points of each set.
pub(super) fn truncated<P: Point>(sets: &[PointSet<P>], n_points: usize) -> Vec<PointSet<P>> {
    let first = |set: &PointSet<P>| {
        let mut set = set.clone();
        truncate(&mut set, n_points);
        set
    };
    sets.iter().map(first).collect()
}

fn truncate<P>(set: &mut PointSet<P>, n_points: usize) {
    set.points.truncate(n_points);
    set.weights.truncate(n_points);
}

impl Sampler for Prefix<'_, dyn Sampler + '_, glam::DVec3> {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.sampler.domain()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_watched(rng, set, progress)?;
        truncate(set, self.n_points);
        Ok(())
    }

    fn distribution(&self) -> SetDistribution<'_> {
        match self.sampler.distribution() {
            SetDistribution::OneOf(_) => SetDistribution::OneOf(&self.sets),
            SetDistribution::Independent => SetDistribution::Independent,
            SetDistribution::Fixed => SetDistribution::Fixed,
            _ => SetDistribution::Random,
        }
    }

    fn nominal_work(&self) -> f64 {
        self.sampler.nominal_work()
    }

    fn stream_group(&self) -> usize {
        self.group
    }
}

impl SquareSampler for Prefix<'_, dyn SquareSampler + '_, [f64; 2]> {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_watched(rng, set, progress)?;
        truncate(set, self.n_points);
        Ok(())
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        match self.sampler.distribution() {
            SquareDistribution::OneOf(_) => SquareDistribution::OneOf(&self.sets),
            SquareDistribution::Independent => SquareDistribution::Independent,
            // A prefix of a lattice is none.
            SquareDistribution::Fixed | SquareDistribution::Lattice(_) => SquareDistribution::Fixed,
            _ => SquareDistribution::Random,
        }
    }

    fn nominal_work(&self) -> f64 {
        self.sampler.nominal_work()
    }

    fn stream_group(&self) -> usize {
        self.group
    }
}
