use std::path::PathBuf;

use sphvar_grammar::{Choice, Declaration, Parametric};

/// Parameters of a HEALPix map in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct HealpixMapParameters {
    /// The file.
    pub file: PathBuf,
    /// The name or number of the column, the first unless given.
    pub field: Option<String>,
    /// The name or number of the HDU, the first that holds a map unless given.
    pub hdu: Option<String>,
    /// The treatment of pixels without a value.
    pub missing: MissingPixels,
}

/// The treatment of pixels without a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingPixels {
    /// They are an error.
    #[default]
    Error,
    /// They are 0.
    Zero,
    /// They are the mean of the others.
    Mean,
}

impl Choice for MissingPixels {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("error", Self::Error), ("0", Self::Zero), ("mean", Self::Mean)];
}

/// An example.
impl Default for HealpixMapParameters {
    fn default() -> Self {
        Self { file: "FILE".into(), field: None, hdu: None, missing: MissingPixels::Error }
    }
}

impl Parametric for HealpixMapParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_file("file", "HEALPix map in a FITS file", &mut self.file);
        d.word("field", "column by name or number from 0", "the first", &mut self.field);
        d.word("hdu", "HDU by name or number", "the first with a map", &mut self.hdu);
        d.choice("missing", "pixels without a value", &mut self.missing);
    }
}
