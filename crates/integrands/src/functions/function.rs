use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

/// Parameters of a function that the program supplies.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionParameters {
    /// Its name, which [`IntegrandResolver::function`] looks up.
    pub name: String,
}

/// An example.
impl Default for FunctionParameters {
    fn default() -> Self {
        Self { name: "NAME".to_owned() }
    }
}

impl Parametric for FunctionParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_name("name", "name of the function in the program", &mut self.name);
    }
}

impl Definition for FunctionParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(files.function(self)?)
    }
}
