use sphvar_warps::{VonMisesFisherLobe, Warp};

use super::WarpDefinition;
use crate::{Domain, Error, IntegrandResolver, VonMisesFisherParameters};

impl WarpDefinition for VonMisesFisherParameters {
    fn build(&self, _: Domain, _: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        Ok(Box::new(VonMisesFisherLobe::new(self.kappa)?))
    }
}
