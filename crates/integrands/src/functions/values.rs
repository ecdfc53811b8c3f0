use std::path::PathBuf;

use sphvar_grammar::{Declaration, Parametric, Range};

use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

/// The largest degree of coefficients.
const MAX_DEGREE: i64 = 1_000_000;

/// Parameters of a least-squares fit to values in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ValuesParameters {
    /// The file.
    pub file: PathBuf,
    /// The maximum degree of the fit.
    pub lmax: usize,
    /// The factor of `sum |F_lm|^2` in the minimized sum.
    pub ridge: f64,
    /// Whether the values are fitted on the hemisphere, by even degrees.
    pub hemisphere: bool,
    /// The meaning of the columns, in the notation of the resolver.
    pub columns: Option<String>,
    /// The table of a FITS file: its number or its name.
    pub hdu: Option<String>,
    /// Whether rows without a direction or with an invalid value are skipped.
    pub skip_invalid: bool,
    /// Whether vectors may have any length.
    pub normalize: bool,
}

/// An example.
impl Default for ValuesParameters {
    fn default() -> Self {
        Self {
            file: "FILE".into(),
            lmax: 20,
            ridge: 0.0,
            hemisphere: false,
            columns: None,
            hdu: None,
            skip_invalid: false,
            normalize: false,
        }
    }
}

impl Parametric for ValuesParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "points with values as CSV or other text, NPY, NPZ, PLY or a FITS table";
        d.required_file("file", summary, &mut self.file);
        d.required_integer("lmax", [0, MAX_DEGREE], "maximum degree of the fit", &mut self.lmax);
        let summary = "factor of sum |F_lm|^2 in the minimized sum";
        d.number("ridge", Range::AT_LEAST_0, summary, &mut self.ridge);
        d.choice("hemisphere", "fit even degrees on the hemisphere", &mut self.hemisphere);
        let summary = "roles of the columns, as in columns=\"ra,dec,value,sigma\"";
        d.word("columns", summary, "by their names", &mut self.columns);
        d.word("hdu", "table of a FITS file", "the first", &mut self.hdu);
        d.choice("skip-invalid", "skip rows with invalid numbers", &mut self.skip_invalid);
        d.choice("normalize", "accept vectors of any length", &mut self.normalize);
    }
}

impl Definition for ValuesParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(files.fitted_values(self)?))
    }
}
