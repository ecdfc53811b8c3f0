use sphvar_grammar::{Parametric, ResolveError};

use crate::{
    EnvironmentMap, EnvironmentParameters, Error, HealpixMap, HealpixMapParameters, Integrand,
};

/// The definition of an integrand, apart from its name and summary in the list of `functions`.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait Definition: Parametric {
    /// Returns the integrand with these parameters; `files` reads the files that they name.
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error>;
}

/// Reads the files named in integrand specifications, as in `env:FILE` and `map:FILE`.
pub trait IntegrandResolver {
    /// Returns the environment map of a file, with its pole at +z.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no such map.
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError>;

    /// Returns the HEALPix map of a file.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no such map.
    fn healpix_map(&self, wanted: &HealpixMapParameters) -> Result<HealpixMap, ResolveError>;
}

/// A resolver that rejects every file.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl IntegrandResolver for NoFiles {
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        Err(unread(&wanted.file))
    }

    fn healpix_map(&self, wanted: &HealpixMapParameters) -> Result<HealpixMap, ResolveError> {
        Err(unread(&wanted.file))
    }
}

fn unread(file: &std::path::Path) -> ResolveError {
    let file = file.display();
    ResolveError::new(format!("cannot read {file}: an integrand from a file needs a resolver"))
}
