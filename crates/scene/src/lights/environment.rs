use std::sync::Arc;

use glam::{DQuat, DVec3};
use sphvar_integrands::{EnvironmentMap, Integrand, PulledBack, Strategy};
use sphvar_samplers::{Domain, PointSet};
use sphvar_warps::{DensityMap, Interpolation, Oriented, Warp};

use super::{DirectionalLight, luminance};
use crate::Error;

/// The incident light by direction, in red, green and blue.
///
/// # Examples
///
/// A sky and the lights of uniform directions:
///
/// ```
/// use glam::DQuat;
/// use sphvar_integrands::EnvironmentMap;
/// use sphvar_samplers::{Domain, Fibonacci, Purpose, Sampler, Streams};
/// use sphvar_scene::{IrradianceReference, RgbEnvironment};
///
/// let sky = |zenith| EnvironmentMap::new(4, 2, [[zenith; 4], [0.1; 4]].concat());
/// let environment = RgbEnvironment::new([sky(0.3)?, sky(0.5)?, sky(1.0)?], DQuat::IDENTITY)?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
/// let set = Fibonacci::new(256, Domain::Sphere)?.sample(&mut rng)?;
/// let lights = environment.uniform_lights(&set);
/// let error = IrradianceReference::new(&environment)?.relative_error(&lights)?;
/// assert!(error.luminance.unwrap() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RgbEnvironment {
    channels: [EnvironmentMap; 3],
    /// From directions of the environment to those of the maps.
    to_map: DQuat,
    luminance: Arc<Oriented<DensityMap>>,
}

impl RgbEnvironment {
    /// Returns the environment with these maps of red, green and blue radiance, with all directions
    /// rotated.
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] unless all have the same size and the same first longitude,
    /// [`Error::Density`] if the luminance is 0 everywhere.
    pub fn new(channels: [EnvironmentMap; 3], rotation: DQuat) -> Result<Self, Error> {
        let layout =
            |map: &EnvironmentMap| (map.width(), map.height(), map.first_longitude().to_bits());
        let map = &channels[0];
        if channels.iter().any(|other| layout(other) != layout(map)) {
            return Err(Error::Channels);
        }
        let [r, g, b] = channels.each_ref().map(EnvironmentMap::texels);
        let texels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| luminance([r, g, b]).abs());
        let (width, height) = (map.width(), map.height());
        let density = DensityMap::new(width, height, texels.collect(), Interpolation::Bilinear)?
            .with_first_longitude(map.first_longitude());
        let luminance = Arc::new(Oriented::new(density, rotation));
        Ok(Self { channels, to_map: rotation.normalize().inverse(), luminance })
    }

    /// Returns the maps of red, green and blue, without the rotation.
    #[must_use]
    pub fn channels(&self) -> &[EnvironmentMap; 3] {
        &self.channels
    }

    /// Returns the rotation from directions of the environment to those of the maps.
    pub(super) fn to_map(&self) -> DQuat {
        self.to_map
    }

    /// Returns the radiance from a direction, a unit vector.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let direction = self.to_map * direction;
        self.channels.each_ref().map(|map| map.eval(direction))
    }

    /// Returns the radiance of a texel by its index, row by row from the north pole.
    pub(super) fn texel(&self, index: usize) -> [f64; 3] {
        self.channels.each_ref().map(|map| map.texels()[index])
    }

    /// Returns the map of the square to directions whose density is proportional to the luminance,
    /// bilinear between the centres of texels: each of N lights from it has the same luminance.
    /// Texels of negative luminance, which are not physical, count by its magnitude.
    #[must_use]
    pub fn luminance_warp(&self) -> Arc<dyn Warp> {
        self.luminance.clone()
    }

    /// Checks that some density is positive wherever a channel is not 0, so that the lights of their
    /// directions lose no light.
    ///
    /// # Errors
    ///
    /// Those of [`PulledBack::check_support`].
    pub fn check_support(&self, strategies: &[Strategy]) -> Result<(), Error> {
        let magnitude = |dir: DVec3| self.radiance(dir).iter().map(|x| x.abs()).sum::<f64>();
        Ok(PulledBack::check_support(&magnitude, Domain::Sphere, strategies)?)
    }

    /// Returns a light for each direction, with the radiance from there times a solid angle.
    ///
    /// N directions of density p stand for solid angles of 1/(N p), and uniform ones of 4 pi/N.
    #[must_use]
    pub fn lights(&self, directions: &[DVec3], solid_angles: &[f64]) -> Vec<DirectionalLight> {
        let light = |(&direction, &solid_angle): (&DVec3, &f64)| DirectionalLight {
            direction,
            irradiance: self.radiance(direction).map(|x| x * solid_angle),
        };
        directions.iter().zip(solid_angles).map(light).collect()
    }

    /// Returns the lights of uniform directions on the sphere, each of which stands for the same
    /// solid angle or, with weights, for one in proportion to its weight.
    #[must_use]
    pub fn uniform_lights(&self, set: &PointSet) -> Vec<DirectionalLight> {
        let unit = Domain::Sphere.area() / set.weight_sums().0;
        let weight = |k| set.weights.get(k).map_or(1.0, |weight: &f64| *weight);
        let solid_angles: Vec<f64> = (0..set.len()).map(|k| weight(k) * unit).collect();
        self.lights(&set.points, &solid_angles)
    }
}
