use sphvar_grammar::{Parametric, ResolveError};
use sphvar_warps::DensityMap;

use crate::{
    AlmParameters, EnergiesParameters, EnergyEstimates, EnvironmentMap, EnvironmentParameters,
    Error, Expansion, FittedFunction, FunctionParameters, HealpixMap, HealpixMapParameters,
    ImageParameters, Integrand, Interpolation, SquareImage, ValuesParameters,
};

/// The definition of an integrand, apart from its name and summary in the list of `functions`.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait Definition: Parametric {
    /// Returns the integrand with these parameters; `files` reads the files that they name.
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error>;
}

/// Reads the files named in integrand specifications, as in `env:FILE`, `map:FILE` and
/// `image:FILE`, and supplies the functions of the program, as in `function:NAME`. What it does not
/// implement is rejected.
pub trait IntegrandResolver {
    /// Returns the environment map of a file, with its pole at +z.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no such map.
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the density of an environment map, with its pole at +z. A resolver that keeps maps
    /// returns clones, which share their texels.
    ///
    /// # Errors
    ///
    /// Those of [`environment`](Self::environment) and [`EnvironmentMap::into_density`].
    fn environment_density(
        &self,
        wanted: &EnvironmentParameters,
        interpolation: Interpolation,
    ) -> Result<DensityMap, Error> {
        wanted.density(self.environment(wanted)?, interpolation, |text| self.remark(text))
    }

    /// Returns the HEALPix map of a file.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no such map.
    fn healpix_map(&self, wanted: &HealpixMapParameters) -> Result<HealpixMap, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the energies of a file; 0 for degree 0 where the file starts at 1.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no energies.
    fn energies(&self, wanted: &EnergiesParameters) -> Result<EnergyEstimates, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the function whose coefficients are in a file.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no coefficients of a real function.
    fn expansion(&self, wanted: &AlmParameters) -> Result<Expansion, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the fit to the values of a file.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no values, or they do not determine the fit.
    fn fitted_values(&self, wanted: &ValuesParameters) -> Result<FittedFunction, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the picture of a file as a function on the square.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if the file has no such picture.
    fn square_image(&self, wanted: &ImageParameters) -> Result<SquareImage, ResolveError> {
        Err(unread(&wanted.file))
    }

    /// Returns the function of the program that has a name, for the term `function:NAME` of
    /// expressions. [`SharedFunction`](crate::SharedFunction) makes it available more than once.
    ///
    /// # Errors
    ///
    /// [`ResolveError`] with the reason if there is no such function.
    ///
    /// # Examples
    ///
    /// ```
    /// use glam::DVec3;
    /// use sphvar_integrands::grammar::ResolveError;
    /// use sphvar_integrands::{
    ///     Domain, Expression, FunctionParameters, Integrand, IntegrandResolver, SampledFunction,
    /// };
    ///
    /// struct Own;
    ///
    /// impl IntegrandResolver for Own {
    ///     fn function(&self, wanted: &FunctionParameters) -> Result<Box<dyn Integrand>, ResolveError> {
    ///         match &*wanted.name {
    ///             "wave" => Ok(Box::new(SampledFunction::new(|d: DVec3| d.x * d.x, 2))),
    ///             name => Err(ResolveError::new(format!("there is no function {name}"))),
    ///         }
    ///     }
    /// }
    ///
    /// let expression: Expression = "2 * function:wave @ 30/0 - cosine".parse()?;
    /// let integral = expression.build(&Own)?.exact(Domain::Sphere).unwrap();
    /// assert!((integral - (8.0 / 3.0 - 1.0) * std::f64::consts::PI).abs() < 1e-14);
    /// # Ok::<(), sphvar_integrands::Error>(())
    /// ```
    fn function(&self, wanted: &FunctionParameters) -> Result<Box<dyn Integrand>, ResolveError> {
        Err(ResolveError::new(format!(
            "function:{}: only programs that use the library supply functions of their own, such as \
             a callable in Python",
            wanted.name
        )))
    }

    /// Returns the check that a function of a degree fits in memory, which its first value calls;
    /// the error is the reason why it does not. By default every degree passes.
    fn memory_check(&self) -> fn(usize) -> Result<(), String> {
        |_| Ok(())
    }

    /// Receives a remark for the user on an integrand; by default remarks are dropped.
    fn remark(&self, _text: String) {}
}

/// A resolver that rejects every file.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl IntegrandResolver for NoFiles {}

fn unread(file: &std::path::Path) -> ResolveError {
    let file = file.display();
    ResolveError::new(format!("cannot read {file}: an integrand from a file needs a resolver"))
}
