use std::f64::consts::PI;
use std::path::PathBuf;

use sphvar_grammar::{Choice, Declaration, Parametric};

use super::{FittedFunction, RandomField};
use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

/// Parameters of a random function whose energy per degree is in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergiesParameters {
    /// The file.
    pub file: PathBuf,
    /// The meaning of its values; unless given, that of the name of the column.
    pub quantity: Option<EnergyQuantity>,
    /// The number of the random field.
    pub field: u64,
}

/// Energies per degree, possibly estimated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyEstimates {
    /// `E(l) = sum_m |a_lm|^2` from degree 0, none negative.
    pub per_degree: Vec<f64>,
    /// The standard errors of the energies; those beyond the end are 0.
    pub stderr: Vec<f64>,
}

/// A normalization of energies per degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyQuantity {
    /// `E(l) = sum_m |a_lm|^2`.
    Energy,
    /// The angular power spectrum `C_l = E(l)/(2l+1)`.
    AngularPower,
}

impl Choice for EnergyQuantity {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("energy", Self::Energy), ("cl", Self::AngularPower)];
}

/// An example.
impl Default for EnergiesParameters {
    fn default() -> Self {
        Self { file: "FILE".into(), quantity: None, field: 0 }
    }
}

impl Parametric for EnergiesParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_file("file", "text file with columns l and energy, or l and cl", &mut self.file);
        let default = "energy, or cl if the header names that column";
        let summary = "energy: E(l) = sum over m of |a_lm|^2; cl: E(l)/(2l+1)";
        d.optional_choice("quantity", summary, default, &mut self.quantity);
        d.integer("field", [0, i64::MAX], "number of the random field", &mut self.field);
    }
}

impl Definition for EnergiesParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        let EnergyEstimates { per_degree, stderr } = files.energies(self)?;
        let (mean_square, rest) = match per_degree.split_first() {
            Some((first, rest)) => (first / (4.0 * PI), rest),
            None => (0.0, &[][..]),
        };
        // Negative energies are errors, also of degree 0.
        if mean_square < 0.0 {
            return Err(Error::Energy { l: 0, got: per_degree[0] });
        }
        let field = RandomField::new(mean_square.sqrt(), rest, self.field)?;
        let field = field.with_memory_check(files.memory_check());
        if stderr.iter().all(|error| *error == 0.0) {
            return Ok(Box::new(field));
        }
        // The field has the stated energies exactly; their errors are those of the function that
        // they were estimated for.
        Ok(Box::new(FittedFunction::of_estimates(field.expansion()?.clone(), stderr)))
    }
}
