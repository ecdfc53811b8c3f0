use sphvar_grammar::Parametric;
use sphvar_warps::{ConcentricHemisphere, OctahedralSphere, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver};

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl WarpDefinition for Parameters {
    fn build(&self, domain: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        Ok(match domain {
            Domain::Sphere => Box::new(OctahedralSphere),
            // The upper half of the map, which the square fills after a rotation by 45 degrees.
            Domain::Hemisphere => Box::new(ConcentricHemisphere),
        })
    }
}
