use sphvar_samplers::{
    PointSet, Purpose, SquarePattern, SquareRealizations, SquareSampler, Streams,
};

use crate::Error;

/// The point sets of a pattern of the unit square, as the pattern generates them: a shift modulo 1
/// would not change their power spectra.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneEnsemble {
    /// The pattern.
    pub pattern: SquarePattern,
    /// The number of points of a set.
    pub n_points: usize,
}

impl PlaneEnsemble {
    /// Returns sets with the valid count nearest to `n_points`.
    #[must_use]
    pub fn new(pattern: SquarePattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(n_points);
        Self { pattern, n_points }
    }

    /// Returns set `index` of the ensemble.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if it cannot be generated.
    pub fn set(&self, seed: u64, index: u64) -> Result<Vec<[f64; 2]>, Error> {
        let sampler = self.sampler()?;
        let mut set = PointSet::default();
        self.realizations(&*sampler, seed).realize_into(index, &mut set, &())?;
        Ok(set.points)
    }

    pub(crate) fn sampler(&self) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(self.pattern.build(self.n_points)?)
    }

    pub(crate) fn realizations<'a>(
        &self,
        sampler: &'a dyn SquareSampler,
        seed: u64,
    ) -> SquareRealizations<'a> {
        let streams = Streams::new(seed, Purpose::Pattern, sampler.stream_group());
        SquareRealizations::unshifted(sampler, streams)
    }

    /// Returns a text that distinguishes the ensemble from all others.
    pub(crate) fn key(&self) -> String {
        format!("{} n={} square", self.pattern, self.n_points)
    }
}
