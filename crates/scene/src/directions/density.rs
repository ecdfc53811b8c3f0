use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use sphvar_warps::{CosineHemisphere, Measure, Warp, WarpSample};

use super::frame::frame;
use super::light_warp::LightWarp;
use crate::{Error, LightMap, Quad, ShadingPoint};

/// A density of directions at each shading point, with the map that samples it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Density {
    /// A map about the surface: +z is the normal.
    Surface(Arc<dyn Warp>),
    /// A map of world directions, such as that of an environment, the same at every point. The part
    /// below a surface is sampled but contributes nothing.
    World {
        /// The map.
        warp: Arc<dyn Warp>,
        /// The rotation from the frame of the map to the world.
        rotation: DQuat,
    },
    /// The solid angle of a light, uniformly. The part below a surface contributes nothing.
    Light {
        /// The light, lit along its normal.
        light: Quad,
        /// The map.
        map: LightMap,
    },
}

/// A density at one shading point.
pub(crate) enum LocalDensity<'a> {
    Warp(&'a dyn Warp, DMat3),
    Light(Box<LightWarp<'a>>),
    /// The density is 0 everywhere: a light that the point does not see.
    None,
}

impl Density {
    /// Returns the density cos(theta)/pi about the normal.
    #[must_use]
    pub fn cosine() -> Self {
        Self::Surface(Arc::new(CosineHemisphere))
    }

    /// Nominal work of a direction: the time of a sample of the slowest map of each kind, see the
    /// crate `warps`.
    pub(crate) fn nominal_work(&self) -> f64 {
        match self {
            Self::Surface(_) => 1.0,
            Self::World { .. } => 7.0,
            Self::Light { .. } => 22.0,
        }
    }

    /// Rejects maps to the disk.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self {
            Self::Surface(warp) | Self::World { warp, .. }
                if warp.measure() != Measure::SolidAngle =>
            {
                Err(Error::NoDirections)
            }
            _ => Ok(()),
        }
    }

    /// Returns the density at a shading point.
    pub(crate) fn at(&self, point: &ShadingPoint<'_>) -> LocalDensity<'_> {
        match self {
            Self::Surface(warp) => LocalDensity::Warp(&**warp, frame(point.normal())),
            Self::World { warp, rotation } => {
                LocalDensity::Warp(&**warp, DMat3::from_quat(*rotation))
            }
            Self::Light { light, map } => match LightWarp::new(light, *map, point.origin()) {
                Some(warp) => LocalDensity::Light(Box::new(warp)),
                None => LocalDensity::None,
            },
        }
    }
}

impl LocalDensity<'_> {
    /// Returns the direction of a point of the square with its density; `None` if there are none.
    pub(crate) fn sample(&self, point: [f64; 2]) -> Option<WarpSample> {
        match self {
            Self::Warp(warp, rotation) => {
                let WarpSample { point, density } = warp.sample(point);
                Some(WarpSample { point: *rotation * point, density })
            }
            Self::Light(warp) => Some(warp.sample(point)),
            Self::None => None,
        }
    }

    /// Returns the density per steradian.
    pub(crate) fn density(&self, dir: DVec3) -> f64 {
        match self {
            Self::Warp(warp, rotation) => warp.density(rotation.transpose() * dir),
            Self::Light(warp) => warp.density(dir),
            Self::None => 0.0,
        }
    }
}
