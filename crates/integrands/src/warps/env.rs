use glam::{DQuat, DVec3};
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_warps::{DensityMap, Oriented, Warp};

use super::WarpDefinition;
use crate::{
    Domain, EnvironmentMap, EnvironmentParameters, Error, IntegrandResolver, Interpolation,
};

/// Parameters of the density of an environment map in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentWarpParameters {
    /// The map, as for the integrand.
    pub environment: EnvironmentParameters,
    /// The density between the centres of texels.
    pub interpolation: Interpolation,
    /// The share of the uniform density in the mixture, from 0 to less than 1.
    pub floor: f64,
}

/// An example.
impl Default for EnvironmentWarpParameters {
    fn default() -> Self {
        let environment = EnvironmentParameters::default();
        Self { environment, interpolation: Interpolation::default(), floor: 0.0 }
    }
}

impl Parametric for EnvironmentWarpParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let Self { environment, interpolation, floor } = self;
        let file = "OpenEXR or Radiance HDR picture; negative texels count by magnitude";
        d.required_file("file", file, &mut environment.file);
        let channels = "luminance, r, g, b or a channel's name in the file";
        environment.picture.declare_with(channels, d);
        let summary = "between texel centres, as the integrand, or constant on each texel";
        d.choice("interpolation", summary, interpolation);
        let summary =
            "share of the uniform density mixed in, where the map is 0 and the integrand is not";
        d.number("floor", Range::right_open(0.0, 1.0), summary, floor);
    }
}

impl EnvironmentParameters {
    /// Returns the density of the map with these parameters, for implementations of
    /// [`IntegrandResolver`]; `remark` receives the number of negative texels.
    ///
    /// # Errors
    ///
    /// Those of [`EnvironmentMap::into_density`].
    pub fn density(
        &self,
        map: EnvironmentMap,
        interpolation: Interpolation,
        remark: impl FnOnce(String),
    ) -> Result<DensityMap, Error> {
        let n_negative = map.texels().iter().filter(|texel| **texel < 0.0).count();
        if n_negative > 0 {
            let (file, len) = (self.file.display(), map.texels().len());
            remark(format!(
                "{file}: {n_negative} of {len} texels are negative; the density takes their magnitudes"
            ));
        }
        map.into_density(interpolation)
    }
}

impl WarpDefinition for EnvironmentWarpParameters {
    fn build(&self, domain: Domain, files: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error> {
        self.rotated(DQuat::IDENTITY, domain, files)
    }
}

impl EnvironmentWarpParameters {
    /// Returns the density after a rotation; on the hemisphere, that part of it if the pole of the
    /// map is at +z, otherwise the density on the sphere.
    pub(super) fn rotated(
        &self,
        rotation: DQuat,
        domain: Domain,
        files: &dyn IntegrandResolver,
    ) -> Result<Box<dyn Warp>, Error> {
        let map = files.environment_density(&self.environment, self.interpolation)?;
        let rotation = rotation * self.rotation_of_pole();
        let Some(angle) = angle_about_pole(rotation) else {
            return Ok(Box::new(Oriented::new(map.with_floor(self.floor)?, rotation)));
        };
        let map = match domain {
            Domain::Sphere => map,
            Domain::Hemisphere => map.on_hemisphere()?,
        };
        Ok(Box::new(map.rotated_about_pole(angle).with_floor(self.floor)?))
    }

    /// Returns the product of the density, after a rotation, and the cosine about an axis, after
    /// another; `None` unless both have the same axis.
    pub(super) fn times_cosine(
        &self,
        rotation: DQuat,
        rotation_of_cosine: DQuat,
        files: &dyn IntegrandResolver,
    ) -> Result<Option<Box<dyn Warp>>, Error> {
        let Some(angle) = self.angle_to(rotation, rotation_of_cosine) else {
            return Ok(None);
        };
        let map = files.environment_density(&self.environment, self.interpolation)?;
        let map = map.rotated_about_pole(angle).times_cosine()?.with_floor(self.floor)?;
        let is_rotated = rotation_of_cosine != DQuat::IDENTITY;
        Ok(Some(match is_rotated {
            true => Box::new(Oriented::new(map, rotation_of_cosine)),
            false => Box::new(map),
        }))
    }

    /// Returns the angle about the common axis of the map and of a cosine, each after a rotation;
    /// `None` if they have different axes.
    pub(super) fn angle_to(&self, rotation: DQuat, rotation_of_cosine: DQuat) -> Option<f64> {
        angle_about_pole(rotation_of_cosine.inverse() * rotation * self.rotation_of_pole())
    }

    fn rotation_of_pole(&self) -> DQuat {
        self.environment.picture.rotation_of_pole().unwrap_or(DQuat::IDENTITY)
    }
}

/// Returns the angle of a rotation about +z, or `None` for other rotations.
pub(super) fn angle_about_pole(rotation: DQuat) -> Option<f64> {
    /// The rounding error of a few rotations.
    const ROUNDING: f64 = 1e-15;
    let pole = rotation * DVec3::Z;
    let x = rotation * DVec3::X;
    (pole.z > 0.0 && pole.x.hypot(pole.y) <= ROUNDING).then(|| x.y.atan2(x.x))
}
