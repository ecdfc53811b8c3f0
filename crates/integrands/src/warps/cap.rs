use std::f64::consts::FRAC_PI_2;

use sphvar_warps::{UniformCap, Warp};

use super::WarpDefinition;
use crate::{CapParameters, Domain, Error, IntegrandResolver};

/// On the hemisphere, that part of the cap.
impl WarpDefinition for CapParameters {
    fn build(&self, domain: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        let half_angle = self.degrees.to_radians();
        Ok(Box::new(match domain {
            Domain::Hemisphere if half_angle >= FRAC_PI_2 => UniformCap::HEMISPHERE,
            _ => UniformCap::new(half_angle)?,
        }))
    }
}
