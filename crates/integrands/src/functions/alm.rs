use std::path::PathBuf;

use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

/// Parameters of a function whose harmonic coefficients are in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct AlmParameters {
    /// The file.
    pub file: PathBuf,
    /// The name or number of the HDU of a FITS file, the first table unless given.
    pub hdu: Option<String>,
}

/// An example.
impl Default for AlmParameters {
    fn default() -> Self {
        Self { file: "FILE".into(), hdu: None }
    }
}

impl Parametric for AlmParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "complex NPY array in the order of healpy, or FITS table of healpy";
        d.required_file("file", summary, &mut self.file);
        d.word("hdu", "HDU by name or number", "the first table", &mut self.hdu);
    }
}

impl Definition for AlmParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(files.expansion(self)?))
    }
}
