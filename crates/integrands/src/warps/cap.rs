use sphvar_warps::{UniformCap, Warp};

use super::WarpDefinition;
use crate::{CapParameters, Domain, Error, IntegrandResolver};

/// On the hemisphere, that part of the cap.
impl WarpDefinition for CapParameters {
    fn build(&self, domain: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        let is_hemisphere = match domain {
            Domain::Sphere => self.degrees.to_bits() == 90f64.to_bits(),
            Domain::Hemisphere => self.degrees >= 90.0,
        };
        Ok(Box::new(match is_hemisphere {
            true => UniformCap::HEMISPHERE,
            false => UniformCap::new(self.degrees.to_radians())?,
        }))
    }
}
