use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::polar::{drop_from_pole, half_open, is_within, turns};
use crate::{Error, Support, Warp, WarpSample, archimedes};

/// Uniform directions of the cap about +z, by the cylinder map of Archimedes:
///
/// ```text
/// z = 1 - h u,   phi = 2 pi v,   p = 1/(2 pi h)
/// ```
///
/// with height h = 1 - cos(half angle). [`SPHERE`](Self::SPHERE) and
/// [`HEMISPHERE`](Self::HEMISPHERE) are the caps of height 2 and 1. Away from the poles the map
/// changes shapes little; at the poles u = 0 and (sphere) u = 1 collapse to a point.
///
/// Round trips are accurate to 2e-15 for every half angle.
///
/// # Examples
///
/// ```
/// use sphvar_warps::{UniformCap, Warp};
///
/// let cap = UniformCap::new(0.25)?;
/// assert!(cap.map([0.9, 0.1]).z > 0.25f64.cos());
/// assert_eq!(cap.density(-glam::DVec3::Z), 0.0);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
///
/// # References
///
/// Archimedes; Shao and Badler 1996.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformCap {
    height: f64,
}

impl UniformCap {
    /// The sphere.
    pub const SPHERE: Self = Self { height: 2.0 };
    /// The hemisphere z >= 0.
    pub const HEMISPHERE: Self = Self { height: 1.0 };
    /// The smallest half angle, below which the height is no longer a normal number.
    const MIN_HALF_ANGLE: f64 = 1e-150;

    /// Returns the cap of a half angle in [1e-150, pi] radians.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(half_angle: f64) -> Result<Self, Error> {
        if !(Self::MIN_HALF_ANGLE..=PI).contains(&half_angle) {
            let range = "in [1e-150, pi]";
            return Err(Error::Parameter { name: "half angle", range, got: half_angle });
        }
        let sin = (0.5 * half_angle).sin();
        Ok(Self { height: 2.0 * sin * sin })
    }

    fn value(self) -> f64 {
        1.0 / (TAU * self.height)
    }
}

impl Warp for UniformCap {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        WarpSample { point: archimedes(self.height * u, TAU * v), density: self.value() }
    }

    fn density(&self, dir: DVec3) -> f64 {
        if is_within(drop_from_pole(dir), self.height) { self.value() } else { 0.0 }
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let drop = drop_from_pole(dir);
        is_within(drop, self.height).then(|| [half_open(drop / self.height), turns(dir)])
    }

    fn support(&self) -> Support {
        if *self == Self::SPHERE {
            Support::Sphere
        } else if *self == Self::HEMISPHERE {
            Support::UpperHemisphere
        } else {
            Support::Directions
        }
    }

    fn min_density(&self) -> f64 {
        self.value()
    }
}
