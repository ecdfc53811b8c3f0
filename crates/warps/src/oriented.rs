use glam::{DMat3, DQuat, DVec3};

use crate::{Error, Measure, Support, Warp, WarpSample};

/// A map of directions, rotated.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_warps::{Oriented, PhongLobe, Warp};
///
/// let lobe = Oriented::towards(PhongLobe::new(100.0)?, DVec3::new(0.0, 3.0, 4.0))?;
/// assert!(lobe.map([0.0, 0.5]).distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-15);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oriented<W> {
    warp: W,
    rotation: DMat3,
}

impl<W: Warp> Oriented<W> {
    /// Returns the map with all its directions rotated.
    #[must_use]
    pub fn new(warp: W, rotation: DQuat) -> Self {
        Self { warp, rotation: DMat3::from_quat(rotation.normalize()) }
    }

    /// Returns the map with +z rotated to the direction of `axis`, which need not be a unit vector.
    ///
    /// # Errors
    ///
    /// [`Error::Degenerate`] if `axis` is 0 or not finite.
    pub fn towards(warp: W, axis: DVec3) -> Result<Self, Error> {
        let requirement = "a finite length other than 0";
        // Scaled first, because squares of the components may overflow or underflow.
        let axis = (axis / axis.abs().max_element())
            .try_normalize()
            .ok_or(Error::Degenerate { shape: "the axis", requirement })?;
        let (x, y) = axis.any_orthonormal_pair();
        Ok(Self { warp, rotation: DMat3::from_cols(x, y, axis) })
    }

    fn unrotate(&self, dir: DVec3) -> DVec3 {
        self.rotation.transpose() * dir
    }
}

impl<W: Warp> Warp for Oriented<W> {
    fn sample(&self, point: [f64; 2]) -> WarpSample {
        let WarpSample { point, density } = self.warp.sample(point);
        WarpSample { point: self.rotation * point, density }
    }

    fn density(&self, dir: DVec3) -> f64 {
        self.warp.density(self.unrotate(dir))
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        self.warp.inverse(self.unrotate(dir))
    }

    fn measure(&self) -> Measure {
        self.warp.measure()
    }

    fn support(&self) -> Support {
        match self.warp.support() {
            Support::UpperHemisphere => Support::Directions,
            support => support,
        }
    }

    fn min_density(&self) -> f64 {
        self.warp.min_density()
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        self.warp.breaks_in_u()
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        self.warp.breaks_in_v(u)
    }
}
