use glam::{DQuat, DVec3};

pub use super::picture_parameters::EnvironmentParameters;
use super::{Rotated, UpAxis};
use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

impl Definition for EnvironmentParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        let map = files.environment(self)?;
        match self.picture.up {
            None | Some(UpAxis::PlusZ) => Ok(Box::new(map)),
            Some(up) => {
                let to_pole = DQuat::from_rotation_arc(up.direction(), DVec3::Z).inverse();
                Ok(Box::new(Rotated::new(map, to_pole)?))
            }
        }
    }
}
