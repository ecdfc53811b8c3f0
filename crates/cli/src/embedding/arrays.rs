//! Adds arrays to a session, with checks of their shapes.

use std::sync::Arc;

use sphvar_healpix::Nside;
use sphvar_integrands::Integrand;
use sphvar_samplers::ProfileTable;

use super::{Failure, PointTable};
use crate::files::{FitsMap, PictureArray, SpectrumRow, alm_of_array};
use crate::given::EnergyArray;
use crate::session::Session;

impl Session {
    /// Makes points available as `file:NAME` in samplers, as a file of `--points` and, with values,
    /// as `values:NAME` in integrands. Their content is checked where they are used, as that of a file.
    ///
    /// # Errors
    ///
    /// If the numbers are not those of whole points in sets of equal size, or weights, values or
    /// errors are not one per point.
    pub fn add_points(&self, name: &str, table: PointTable) -> Result<(), Failure> {
        table.check(name).map_err(Failure::usage)?;
        self.given.add_points(name, Arc::new(table));
        Ok(())
    }

    /// Makes a picture available as `env:NAME` and `image:NAME`: its rows from the top, each texel
    /// one number, or red, green and blue.
    ///
    /// # Errors
    ///
    /// If the texels are not `width * height` times 1 or 3 numbers.
    pub fn add_picture(
        &self,
        name: &str,
        width: usize,
        height: usize,
        texels: Vec<f64>,
    ) -> Result<(), Failure> {
        let picture = PictureArray::new(width, height, texels);
        let picture = picture.map_err(|error| Failure::usage(format!("{name}: {error}")))?;
        self.given.add_picture(name, Arc::new(picture));
        Ok(())
    }

    /// Makes a HEALPix map available as `map:NAME`.
    ///
    /// # Errors
    ///
    /// If the number of values is not that of the pixels of a resolution.
    pub fn add_map(&self, name: &str, values: Vec<f64>, nested: bool) -> Result<(), Failure> {
        let nside = Nside::from_n_pixels(values.len() as u64)
            .map_err(|error| Failure::usage(format!("{name}: {error}")))?
            .value();
        self.given.add_map(name, Arc::new(FitsMap { nside, nested, values, coordinates: None }));
        Ok(())
    }

    /// Makes the function with these coefficients available as `alm:NAME`: real and imaginary parts
    /// in the order of healpy, to degree and order `lmax`.
    ///
    /// # Errors
    ///
    /// If the number of coefficients is not (lmax + 1)(lmax + 2)/2, or one is not finite.
    pub fn add_coefficients(&self, name: &str, coefficients: &[[f64; 2]]) -> Result<(), Failure> {
        let alm = alm_of_array(name, coefficients).map_err(Failure::usage)?;
        self.given.add_coefficients(name, Arc::new(alm));
        Ok(())
    }

    /// Makes energies per degree from 0 available as `energy:NAME`, with their standard errors if
    /// they are known; `quantity=cl` takes them as `C_l`.
    ///
    /// # Errors
    ///
    /// If the standard errors are not as many; energies are checked where they are used.
    pub fn add_energies(
        &self,
        name: &str,
        energies: Vec<f64>,
        errors: Option<Vec<f64>>,
    ) -> Result<(), Failure> {
        if let Some(errors) = &errors
            && errors.len() != energies.len()
        {
            let (n, got) = (energies.len(), errors.len());
            return Err(Failure::usage(format!(
                "{name}: expected a standard error for each of {n} energies, got {got}"
            )));
        }
        self.given.add_energies(name, Arc::new(EnergyArray { values: energies, errors }));
        Ok(())
    }

    /// Makes a spectral profile or pair correlation available as `profile:NAME` in samplers.
    pub fn add_profile(&self, name: &str, profile: ProfileTable) {
        self.given.add_profile(name, Arc::new(profile));
    }

    /// Makes a spectrum available as `--spectrum NAME`: powers by degree from 0, their standard
    /// errors, 0 where a power is exact, and the number of realizations, 0 if it is unknown.
    ///
    /// # Errors
    ///
    /// If there are no powers, the standard errors are not as many, or a number is negative or not
    /// finite.
    pub fn add_spectrum(
        &self,
        name: &str,
        power: &[f64],
        stderr: &[f64],
        realizations: u64,
    ) -> Result<(), Failure> {
        let (powers, errors) = (power.len(), stderr.len());
        if powers == 0 || powers != errors {
            return Err(Failure::usage(format!(
                "{name}: expected a power and a standard error for each degree from 0, got \
                 {powers} and {errors}"
            )));
        }
        let mut rows = Vec::with_capacity(powers);
        for (l, (&value, &stderr)) in power.iter().zip(stderr).enumerate() {
            let is_valid = |number: f64| number.is_finite() && number >= 0.0;
            if !is_valid(value) || !is_valid(stderr) {
                return Err(Failure::usage(format!(
                    "{name}: degree {l} has the power {value} with the standard error {stderr}; \
                     both must be finite and at least 0"
                )));
            }
            rows.push(SpectrumRow { l, value, stderr, realizations });
        }
        self.given.add_spectrum(name, rows.into());
        Ok(())
    }

    /// Makes a function available as `function:NAME` in integrands.
    pub fn add_function(&self, name: &str, function: Arc<dyn Integrand + Send + Sync>) {
        self.given.add_function(name, function);
    }
}
