use crate::pattern_list::PatternList;
use crate::{
    Error, FileResolver, Square, SquareHaltonParameters, SquareHammersleyParameters, SquarePattern,
    SquareSampler, SquareSobolParameters, ValidCounts,
};

impl SquarePattern {
    /// The sequence of Sobol with its default scrambling.
    pub const SOBOL: Self = Self::Sobol(SquareSobolParameters::DEFAULT);
    /// The Halton sequence without scrambling.
    pub const HALTON: Self = Self::Halton(SquareHaltonParameters::DEFAULT);
    /// The Hammersley sets without scrambling.
    pub const HAMMERSLEY: Self = Self::Hammersley(SquareHammersleyParameters::DEFAULT);

    /// Reads `name` or `name:key=value,key=value`; `files` reads the files that the text names.
    ///
    /// # Errors
    ///
    /// [`Error::Grammar`] with place, reason and valid values; [`Error::File`] if `files` cannot
    /// read a file.
    pub fn parse(text: &str, files: &dyn FileResolver) -> Result<Self, Error> {
        Self::read(text, files)
    }

    /// Returns the name in tables and plots, as [`Pattern::label`](crate::Pattern::label) does.
    #[must_use]
    pub fn label(&self) -> String {
        match self {
            Self::PointFile(file) => Self::PointFile(file.shortened()).to_string(),
            _ => self.to_string(),
        }
    }

    /// Returns the number of points of a pattern that has only one, because it is a single point
    /// file.
    #[must_use]
    pub fn own_count(&self) -> Option<usize> {
        match self {
            Self::PointFile(file) => file.own_count(),
            _ => None,
        }
    }

    /// Returns the valid numbers of points.
    #[must_use]
    pub fn valid_counts(&self) -> ValidCounts {
        self.counts_in(Square)
    }

    /// Returns the valid number of points nearest to `requested`, the smaller one of two equally
    /// near; never 0.
    #[must_use]
    pub fn nearest_count(&self, requested: usize) -> usize {
        self.valid_counts().nearest(requested)
    }

    /// Returns the sampler of this pattern with exactly `n_points` points.
    ///
    /// ```
    /// use sphvar_samplers::{Error, SquarePattern};
    /// assert_eq!(SquarePattern::JitteredSquare.build(64)?.n_points(), 64);
    /// let rejected = SquarePattern::JitteredSquare.build(70).unwrap_err();
    /// assert!(matches!(rejected, Error::InvalidCount { nearest: 64, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Pattern::build`](crate::Pattern::build).
    pub fn build(&self, n_points: usize) -> Result<Box<dyn SquareSampler>, Error> {
        self.build_in(n_points, Square)
    }

    /// Returns [`SquareSampler::nominal_work`] of the sampler of `n_points` points, or of the
    /// nearest valid count; one unit per point if the pattern cannot be built.
    #[must_use]
    pub fn nominal_work(&self, n_points: usize) -> f64 {
        let sampler = self.build(self.nearest_count(n_points));
        sampler.map_or(n_points as f64, |sampler| sampler.nominal_work())
    }
}
