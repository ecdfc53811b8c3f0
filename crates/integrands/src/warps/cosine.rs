use sphvar_grammar::Parametric;
use sphvar_warps::{CosineHemisphere, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver};

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl WarpDefinition for Parameters {
    fn build(&self, _: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        Ok(Box::new(CosineHemisphere))
    }
}
