use std::fmt;

use glam::DVec3;
use sphvar_samplers::PointSet;

use crate::{Error, Hit, Quad, Reach, Scene};

/// The integral over the hemisphere above a hit point.
///
/// All are means over the hemisphere, `(1/2 pi) int f`, of the function in brackets. V is 1 if the
/// ray meets nothing, otherwise 0.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Integral<'a> {
    /// Ambient occlusion, the open fraction of the hemisphere: `[V]`, or weighted by the cosine
    /// `[2 V cos]`. Both are 1 without occluders.
    AmbientOcclusion {
        /// The maximum distance of occluders; infinity for no limit.
        max_distance: f64,
        /// Whether directions are weighted by the cosine of their angle to the normal.
        cosine: bool,
    },
    /// The radiance of a diffuse surface under an environment: `[2 albedo V L cos]`, which is
    /// `albedo/pi` times the irradiance. For a constant radiance L without occluders it is
    /// `albedo L`.
    Irradiance {
        /// The radiance from each unit direction, finite and not negative.
        radiance: &'a (dyn Fn(DVec3) -> f64 + Sync),
        /// The reflected fraction of the light.
        albedo: f64,
    },
    /// The radiance of a diffuse surface under a quadrilateral light of radiance 1:
    /// `[2 albedo V cos]` for directions that meet the light, with V up to its distance. The light
    /// emits along its normal and is not part of the scene.
    Light {
        /// The lamp.
        light: &'a Quad,
        /// The reflected fraction of the light.
        albedo: f64,
    },
}

impl Integral<'_> {
    /// Checks that the distance is above 0 and the albedo is in [0, 1].
    ///
    /// # Errors
    ///
    /// Returns [`Error::Setting`] for other values and NaN.
    pub fn check(&self) -> Result<(), Error> {
        let (name, range, got, is_right) = match *self {
            Self::AmbientOcclusion { max_distance: d, .. } => {
                ("the maximum distance of occluders", "above 0", d, d > 0.0)
            }
            Self::Irradiance { albedo, .. } | Self::Light { albedo, .. } => {
                ("the albedo", "in [0, 1]", albedo, (0.0..=1.0).contains(&albedo))
            }
        };
        if is_right { Ok(()) } else { Err(Error::Setting { name, range, got }) }
    }
}

/// Rays to a light extend beyond it by this amount, in units of their length over the cosine at the
/// lamp, so that any surface directly in front of it is intersected. The error in single precision
/// is 2.5 EPSILON for each component of a plane's normal, and 1 for the distance.
const BEYOND_LIGHT: f64 = 8.0 * f32::EPSILON as f64;

/// Sums over the directions of one hit point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    /// The sum of `w f`, with w = 1 for equal weights.
    pub(crate) values: f64,
    /// The sum of `w f^2`.
    pub(crate) squares: f64,
    /// The sum of `(w f)^2`.
    pub(crate) squared_terms: f64,
    /// The number of rays traced.
    pub(crate) rays: u64,
}

/// Buffers that are reused for all hit points.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub(crate) directions: PointSet,
    occluded: Vec<bool>,
    reaches: Vec<f64>,
}

impl Integral<'_> {
    /// Returns the sums over `workspace.directions`, which may change.
    pub(crate) fn sums(&self, scene: &Scene, hit: &Hit, workspace: &mut Workspace) -> Sums {
        let Workspace { directions, occluded, reaches } = workspace;
        let PointSet { points: dirs, weights } = directions;
        let mut reach = Reach::Within(f64::INFINITY);
        match *self {
            Integral::AmbientOcclusion { max_distance, .. } => reach = Reach::Within(max_distance),
            Integral::Irradiance { .. } => (),
            Integral::Light { light, .. } => {
                reaches.clear();
                let origin = scene.ray_origin(hit);
                let (mut next, mut kept) = (0, 0);
                dirs.retain(|&dir| {
                    let cosine = -dir.dot(light.normal());
                    let lit = cosine > 0.0;
                    let distance = if lit { light.intersect(origin, dir) } else { None };
                    reaches.extend(distance.map(|d| d * (1.0 + BEYOND_LIGHT / cosine)));
                    if let (Some(_), Some(&weight)) = (distance, weights.get(next)) {
                        weights[kept] = weight;
                        kept += 1;
                    }
                    next += 1;
                    distance.is_some()
                });
                weights.truncate(kept);
                reach = Reach::ToLamp { lamp: light, distances: reaches };
            }
        }
        occluded.resize(dirs.len(), false);
        scene.occlusion_into(hit, dirs, reach, occluded);
        let mut sums = Sums { rays: dirs.len() as u64, ..Sums::default() };
        let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
        let open = occluded.iter().enumerate().filter(|(_, occluded)| !**occluded);
        if let Integral::AmbientOcclusion { cosine: false, .. } = self {
            let (open, squared_terms) = open.fold((0.0, 0.0), |(sum, squares), (k, _)| {
                (sum + weight(k), squares + weight(k) * weight(k))
            });
            return Sums { values: open, squares: open, squared_terms, ..sums };
        }
        for (k, _) in open {
            let (dir, w) = (dirs[k], weight(k));
            let cosine = 2.0 * hit.normal.dot(dir);
            let f = match *self {
                Integral::AmbientOcclusion { .. } => cosine,
                Integral::Irradiance { radiance, albedo } => albedo * radiance(dir) * cosine,
                Integral::Light { albedo, .. } => albedo * cosine,
            };
            sums.values += w * f;
            sums.squares += w * f * f;
            sums.squared_terms += w * f * (w * f);
        }
        sums
    }
}

impl fmt::Debug for Integral<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AmbientOcclusion { max_distance, cosine } => f
                .debug_struct("AmbientOcclusion")
                .field("max_distance", max_distance)
                .field("cosine", cosine)
                .finish(),
            Self::Irradiance { albedo, .. } => {
                f.debug_struct("Irradiance").field("albedo", albedo).finish_non_exhaustive()
            }
            Self::Light { light, albedo } => {
                f.debug_struct("Light").field("light", light).field("albedo", albedo).finish()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::Integral;

    #[test]
    fn settings_outside_their_range_are_rejected() {
        let ambient = |max_distance| Integral::AmbientOcclusion { max_distance, cosine: true };
        let irradiance = |albedo| Integral::Irradiance { radiance: &|_: DVec3| 1.0, albedo };
        let outside = [f64::NAN, f64::NEG_INFINITY, -1.0];
        for got in outside {
            for integral in [ambient(got), irradiance(got)] {
                let error = integral.check().unwrap_err().to_string();
                assert!(error.ends_with(&format!("got {got}")), "{error}");
            }
        }
        assert!(ambient(0.0).check().is_err());
        for got in [1f64.next_up(), f64::INFINITY] {
            assert!(irradiance(got).check().is_err(), "{got}");
        }
        for got in [f64::MIN_POSITIVE, f64::INFINITY] {
            assert!(ambient(got).check().is_ok(), "{got}");
        }
        for got in [0.0, 1.0] {
            assert!(irradiance(got).check().is_ok(), "{got}");
        }
    }
}
