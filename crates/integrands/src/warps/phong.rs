use sphvar_warps::{PhongLobe, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver, PhongParameters};

impl WarpDefinition for PhongParameters {
    fn build(&self, _: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        Ok(Box::new(PhongLobe::new(self.n)?))
    }
}
