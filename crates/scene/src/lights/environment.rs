use glam::DVec3;
use sphvar_integrands::{EnvironmentMap, Integrand};
use sphvar_warps::{DensityMap, Interpolation};

use super::{DirectionalLight, luminance};
use crate::Error;

/// The incident light by direction, in red, green and blue.
///
/// # Examples
///
/// A sky and the light of N directions that represent the same solid angle each:
///
/// ```
/// use sphvar_integrands::EnvironmentMap;
/// use sphvar_samplers::{Domain, Fibonacci, Purpose, Sampler, Streams};
/// use sphvar_scene::{IrradianceReference, RgbEnvironment};
///
/// let sky = |zenith: f64| EnvironmentMap::new(4, 2, vec![zenith; 4].into_iter().chain([0.1; 4]).collect());
/// let environment = RgbEnvironment::new([sky(0.3)?, sky(0.5)?, sky(1.0)?])?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
/// let set = Fibonacci::new(256, Domain::Sphere)?.sample(&mut rng)?;
/// let lights = environment.lights(&set.points, &[4.0 * std::f64::consts::PI / 256.0; 256]);
/// let error = IrradianceReference::new(&environment)?.relative_error(&lights)?;
/// assert!(error.luminance.unwrap() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RgbEnvironment {
    channels: [EnvironmentMap; 3],
}

impl RgbEnvironment {
    /// Returns the environment with these maps of red, green and blue radiance.
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] unless all have the same size and the same first longitude.
    pub fn new(channels: [EnvironmentMap; 3]) -> Result<Self, Error> {
        let layout =
            |map: &EnvironmentMap| (map.width(), map.height(), map.first_longitude().to_bits());
        if channels.iter().any(|map| layout(map) != layout(&channels[0])) {
            return Err(Error::Channels);
        }
        Ok(Self { channels })
    }

    /// Returns the maps of red, green and blue.
    #[must_use]
    pub fn channels(&self) -> &[EnvironmentMap; 3] {
        &self.channels
    }

    /// Returns the radiance from a direction, a unit vector.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        self.channels.each_ref().map(|map| map.eval(direction))
    }

    /// Returns the radiance of a texel by its index, row by row from the north pole.
    pub(super) fn texel(&self, index: usize) -> [f64; 3] {
        self.channels.each_ref().map(|map| map.texels()[index])
    }

    /// Returns the density of directions that is proportional to the luminance: the density from
    /// which each of N lights has the same luminance.
    ///
    /// # Errors
    ///
    /// [`Error::Density`] if the luminance is negative somewhere or 0 everywhere.
    pub fn luminance_density(&self) -> Result<DensityMap, Error> {
        let map = &self.channels[0];
        let texels = (0..map.texels().len()).map(|i| luminance(self.texel(i))).collect();
        let density = DensityMap::new(map.width(), map.height(), texels, Interpolation::Bilinear)?;
        Ok(density.with_first_longitude(map.first_longitude()))
    }

    /// Returns a light for each direction, with the radiance from there times a solid angle.
    ///
    /// N directions of density p stand for solid angles 1/(N p): 4 pi/N for uniform ones.
    #[must_use]
    pub fn lights(&self, directions: &[DVec3], solid_angles: &[f64]) -> Vec<DirectionalLight> {
        let light = |(&direction, &solid_angle): (&DVec3, &f64)| DirectionalLight {
            direction,
            irradiance: self.radiance(direction).map(|x| x * solid_angle),
        };
        directions.iter().zip(solid_angles).map(light).collect()
    }
}
