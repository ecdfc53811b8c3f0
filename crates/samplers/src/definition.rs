use std::path::Path;

use sphvar_grammar::{Parametric, ResolveError};

use crate::{Domain, Error, PatternFacts, Sampler, ValidCounts};

/// The definition of a pattern, apart from its name and summary in the list of `patterns`.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait Definition: Parametric {
    /// Returns the known properties of the pattern with these parameters.
    fn facts(&self) -> PatternFacts;

    /// Returns the valid numbers of points.
    fn valid_counts(&self, _domain: Domain) -> ValidCounts {
        ValidCounts::Any
    }

    /// Returns the sampler of `n_points` points, a valid number.
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error>;

    /// Reads the files that the parameters name.
    fn resolve(&mut self, _files: &dyn ProfileResolver) -> Result<(), Error> {
        Ok(())
    }
}

/// Reads the files named in pattern specifications, as in `profile:FILE`.
pub trait ProfileResolver {
    /// Returns the powers in a file by degree from 0; degree 0 is ignored.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file cannot be read.
    fn powers(&self, file: &Path) -> Result<Vec<f64>, ResolveError>;
}

/// Rejects every file.
pub(crate) struct WithoutFiles;

impl ProfileResolver for WithoutFiles {
    fn powers(&self, file: &Path) -> Result<Vec<f64>, ResolveError> {
        Err(ResolveError::new(format!(
            "cannot read {}: a pattern from a file needs a resolver; use Pattern::parse",
            file.display()
        )))
    }
}
