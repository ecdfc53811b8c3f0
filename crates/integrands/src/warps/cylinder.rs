use sphvar_grammar::Parametric;
use sphvar_warps::{UniformCap, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver};

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl WarpDefinition for Parameters {
    fn build(&self, domain: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        Ok(Box::new(match domain {
            Domain::Sphere => UniformCap::SPHERE,
            Domain::Hemisphere => UniformCap::HEMISPHERE,
        }))
    }
}
