//! Inputs that are arrays where the embedding program gives one of the name, and files otherwise.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use sphvar_integrands::EnergyQuantity;
use sphvar_samplers::ProfileTable;
use sphvar_sh::Alm;

use crate::error::CliError;
use crate::files::{
    EnergyFile, FilePoint, FitsField, FitsMap, HduChoice, PointFile, ReadOptions, SpectrumRow,
    energies_of_array, point_files, points_of_array, read_alm, read_energies, read_fits_map,
    read_points, read_profile, read_spectrum,
};
use crate::session::Session;

impl Session {
    /// Returns the point sets of an input.
    pub(crate) fn read_points<P: FilePoint>(
        &self,
        path: &Path,
        options: &ReadOptions,
    ) -> Result<PointFile<P>, CliError> {
        let Some(table) = self.given.points(path) else { return Ok(read_points(path, options)?) };
        let name = |option: &str| options.spelling.name(option);
        reject(path, &name("columns"), options.columns.is_some())?;
        reject(path, &name("hdu"), options.hdu != HduChoice::First)?;
        points_of_array(&path.display().to_string(), &table, options).map_err(CliError::of_array)
    }

    /// Returns the inputs that a path names, as [`point_files`] does.
    pub(crate) fn point_files(
        &self,
        path: &Path,
    ) -> Result<Vec<(Option<usize>, PathBuf)>, CliError> {
        match self.given.points(path) {
            Some(_) => Ok(vec![(None, path.to_path_buf())]),
            None => Ok(point_files(path)?),
        }
    }

    /// Returns the profile of an input.
    pub(crate) fn read_profile(&self, path: &Path) -> Result<ProfileTable, CliError> {
        match self.given.profile(path) {
            Some(profile) => Ok((*profile).clone()),
            None => Ok(read_profile(path)?),
        }
    }

    /// Returns the degrees of the spectrum of an input.
    pub(crate) fn read_spectrum(&self, path: &Path) -> Result<Vec<SpectrumRow>, CliError> {
        match self.given.spectrum(path) {
            Some(rows) => Ok(rows.to_vec()),
            None => Ok(read_spectrum(path)?),
        }
    }

    /// Returns the path and the map of an input; the parameters are those of `map:`.
    pub(crate) fn read_map(
        &self,
        path: &Path,
        hdu: Option<&str>,
        field: Option<&str>,
    ) -> Result<(PathBuf, FitsMap), CliError> {
        if let Some(map) = self.given.map(path) {
            reject(path, "hdu", hdu.is_some())?;
            reject(path, "field", field.is_some())?;
            return Ok((path.to_path_buf(), (*map).clone()));
        }
        let (path, hdu) = chosen_hdu(path, hdu)?;
        let field = field.map_or(FitsField::Number(0), |name| FitsField::Name(name.to_owned()));
        let map = read_fits_map(&path, &hdu, &field)?;
        Ok((path, map))
    }

    /// Returns the path and the coefficients of an input; `hdu` is the parameter of `alm:`.
    pub(crate) fn read_coefficients(
        &self,
        path: &Path,
        hdu: Option<&str>,
        remarks: &mut Vec<String>,
    ) -> Result<(PathBuf, Alm), CliError> {
        if let Some(alm) = self.given.coefficients(path) {
            reject(path, "hdu", hdu.is_some())?;
            return Ok((path.to_path_buf(), (*alm).clone()));
        }
        let (path, hdu) = chosen_hdu(path, hdu)?;
        let alm = read_alm(&path, &hdu, remarks)?;
        Ok((path, alm))
    }

    /// Returns the energies of an input.
    pub(crate) fn read_energies(
        &self,
        path: &Path,
        quantity: Option<EnergyQuantity>,
    ) -> Result<EnergyFile, CliError> {
        let Some(array) = self.given.energies(path) else {
            return Ok(read_energies(path, quantity)?);
        };
        let name = path.display().to_string();
        let errors = array.errors.as_deref();
        energies_of_array(&name, &array.values, errors, quantity).map_err(CliError::of_array)
    }
}

impl CliError {
    /// Returns the error of the content of an array, which is invalid as an argument is.
    pub(crate) fn of_array(error: impl Display) -> Self {
        Self::usage(error)
    }
}

/// Rejects an option of a reader of files for an array.
pub(crate) fn reject(path: &Path, option: &str, is_used: bool) -> Result<(), CliError> {
    if is_used {
        return Err(CliError::Usage(format!(
            "{}: {option} is for files, and this is given as an array",
            path.display()
        )));
    }
    Ok(())
}

/// Returns the path of a FITS file and the HDU that its name or the parameter `hdu` selects.
fn chosen_hdu(file: &Path, parameter: Option<&str>) -> Result<(PathBuf, HduChoice), CliError> {
    let (path, hdu) = HduChoice::of_path(file);
    match parameter {
        None => Ok((path, hdu)),
        Some(text) => match text.parse() {
            Ok(hdu) => Ok((path, hdu)),
            Err(e) => Err(CliError::Usage(format!("hdu={text}: {e}"))),
        },
    }
}
