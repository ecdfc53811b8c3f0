use sphvar_grammar::Parametric;
use sphvar_warps::{OctahedralSphere, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver};

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl WarpDefinition for Parameters {
    fn build(&self, domain: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        match domain {
            Domain::Sphere => Ok(Box::new(OctahedralSphere)),
            Domain::Hemisphere => Err(Error::SphereAlone { instead: "cylinder" }),
        }
    }
}
