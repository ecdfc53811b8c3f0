pub use super::map_parameters::HealpixMapParameters;
use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

impl Definition for HealpixMapParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(files.healpix_map(self)?))
    }
}
