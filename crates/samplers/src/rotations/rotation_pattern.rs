use crate::pattern_list::PatternList;
use crate::{
    Error, FileResolver, RotationGroup, RotationPattern, RotationSampler, SamplerFamily,
    ValidCounts,
};

impl RotationPattern {
    /// Reads `name` or `name:key=value,key=value`; `files` reads the files that the text names.
    ///
    /// # Errors
    ///
    /// [`Error::Grammar`] with place, reason and valid values.
    pub fn parse(text: &str, files: &dyn FileResolver) -> Result<Self, Error> {
        Self::read(text, files)
    }

    /// Returns the valid numbers of rotations.
    #[must_use]
    pub fn valid_counts(&self) -> ValidCounts {
        self.counts_in(RotationGroup)
    }

    /// Returns the valid number of rotations nearest to `requested`, the smaller one of two equally
    /// near; never 0.
    #[must_use]
    pub fn nearest_count(&self, requested: usize) -> usize {
        self.valid_counts().nearest(requested)
    }

    /// Returns the sampler of this pattern with exactly `n_points` rotations.
    ///
    /// ```
    /// use sphvar_samplers::{Error, RotationPattern};
    /// let grid: RotationPattern = "healpix-hopf".parse()?;
    /// assert_eq!(grid.build(576)?.n_points(), 576);
    /// let rejected = grid.build(600).unwrap_err();
    /// assert!(matches!(rejected, Error::InvalidCount { nearest: 576, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Pattern::build`](crate::Pattern::build).
    pub fn build(&self, n_points: usize) -> Result<Box<dyn RotationSampler>, Error> {
        self.build_in(n_points, RotationGroup)
    }
}

impl SamplerFamily<RotationGroup> for RotationPattern {
    fn build(&self, n_points: usize, _: RotationGroup) -> Result<Box<dyn RotationSampler>, Error> {
        Self::build(self, n_points)
    }

    fn nearest_count(&self, requested: usize, _: RotationGroup) -> usize {
        Self::nearest_count(self, requested)
    }
}
