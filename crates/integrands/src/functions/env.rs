use glam::{DQuat, DVec3};

pub use super::picture_parameters::EnvironmentParameters;
use super::{PictureParameters, Rotated, UpAxis};
use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

impl Definition for EnvironmentParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        let map = files.environment(self)?;
        Ok(match self.picture.rotation_of_pole() {
            None => Box::new(map),
            Some(rotation) => Box::new(Rotated::new(map, rotation)?),
        })
    }
}

impl PictureParameters {
    /// Returns the rotation from a pole at +z to that of the picture, unless it is at +z.
    pub(crate) fn rotation_of_pole(&self) -> Option<DQuat> {
        let up = self.up.filter(|up| *up != UpAxis::PlusZ)?;
        Some(DQuat::from_rotation_arc(up.direction(), DVec3::Z).inverse())
    }
}
