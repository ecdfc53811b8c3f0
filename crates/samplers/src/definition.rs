use std::path::Path;

use sphvar_grammar::{Parametric, ResolveError};

use crate::{
    Domain, Error, PatternFacts, PointFile, PointFileParameters, Space, SquarePointFileParameters,
    ValidCounts,
};

/// The definition of a pattern, apart from its name and summary in the list of the patterns of its
/// space.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait Definition<S: Space = Domain>: Parametric {
    /// Returns the known properties of the pattern with these parameters.
    fn facts(&self) -> PatternFacts;

    /// Returns the valid numbers of points.
    fn valid_counts(&self, _space: S) -> ValidCounts {
        ValidCounts::Any
    }

    /// Returns the number of points where none is requested, if the parameters determine one.
    fn default_count(&self, _space: S) -> Option<usize> {
        None
    }

    /// Returns the sampler of `n_points` points, a valid number.
    fn build(&self, n_points: usize, space: S) -> Result<Box<S::Sampler>, Error>;

    /// Returns the number that distinguishes the random streams of the sampler of `n_points` points
    /// from those of others, if it does not follow from the text of the pattern.
    fn stream_group(&self, _n_points: usize) -> Option<usize> {
        None
    }

    /// Reads the files that the parameters name.
    fn resolve(&mut self, _files: &dyn FileResolver) -> Result<(), Error> {
        Ok(())
    }
}

/// The content of a file that prescribes the spectrum of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum ProfileTable {
    /// Powers by degree from 0; degree 0 is ignored.
    Powers(Vec<f64>),
    /// Angles in radians, in ascending order, and values of a pair correlation.
    PairCorrelation(Vec<[f64; 2]>),
}

/// Reads the files named in pattern specifications, as in `profile:FILE` and `file:FILE`.
pub trait FileResolver {
    /// Returns the content of the file of a profile.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file cannot be read.
    fn profile(&self, file: &Path) -> Result<ProfileTable, ResolveError>;

    /// Returns the content of a point file, read with the options of `source`. A template, a path
    /// with `{n}`, stands for all files whose names have a number in that place.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if a file cannot be read or a template has none.
    fn points(&self, source: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError>;

    /// Returns the content of a file of points `[u, v]` of the square, or of the files of a
    /// template, as [`Self::points`] does. Default: an error.
    ///
    /// # Errors
    ///
    /// Those of [`Self::points`].
    fn square_points(
        &self,
        source: &SquarePointFileParameters,
    ) -> Result<Vec<PointFile<[f64; 2]>>, ResolveError> {
        Err(without_resolver(source.file()))
    }
}

/// Rejects every file.
pub(crate) struct WithoutFiles;

impl FileResolver for WithoutFiles {
    fn profile(&self, file: &Path) -> Result<ProfileTable, ResolveError> {
        Err(without_resolver(file))
    }

    fn points(&self, source: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        Err(without_resolver(source.file()))
    }
}

fn without_resolver(file: &Path) -> ResolveError {
    ResolveError::new(format!(
        "cannot read {}: a pattern from a file needs a resolver; use Pattern::parse or SquarePattern::parse",
        file.display()
    ))
}
