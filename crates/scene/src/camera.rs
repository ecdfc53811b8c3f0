use glam::DVec3;

use crate::Error;

/// A pinhole camera: rays through the points of an image.
///
/// ```
/// use glam::DVec3;
/// use sphvar_scene::Camera;
///
/// let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90f64.to_radians())?;
/// // The middle of the image, and the middle of its upper edge.
/// assert!(camera.direction(4.0, 2.0, [8, 4]).distance(DVec3::NEG_Z) < 1e-15);
/// assert!(camera.direction(4.0, 0.0, [8, 4]).distance(DVec3::new(0.0, 1.0, -1.0).normalize()) < 1e-15);
/// # Ok::<(), sphvar_scene::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    position: DVec3,
    forward: DVec3,
    /// Half the image's height at distance 1, upwards and to the right.
    up: DVec3,
    right: DVec3,
}

impl Camera {
    /// A camera at `position` that has `target` in the middle of its image.
    ///
    /// `up` appears upwards, it need be neither of unit length nor perpendicular to the view.
    /// `field_of_view` is the angle between the lower and the upper edge, radians, in (0, pi).
    ///
    /// # Errors
    /// [`Error::Camera`] if a number is not finite, the target is at the position, `up` is along the
    /// view, or the angle is out of range.
    pub fn look_at(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        field_of_view: f64,
    ) -> Result<Self, Error> {
        let refuse = |expected| Err(Error::Camera { expected });
        if !position.is_finite() || !target.is_finite() || !up.is_finite() {
            return refuse("finite coordinates");
        }
        if !(field_of_view > 0.0 && field_of_view < std::f64::consts::PI) {
            return refuse("a field of view above 0 and below 180 degrees");
        }
        let Some(forward) = (target - position).try_normalize() else {
            return refuse("a target apart from its position");
        };
        let Some(up) = up.try_normalize() else { return refuse("an upward direction") };
        // Rounding alone leaves about one EPSILON of a parallel direction.
        let right = forward.cross(up);
        if right.length() < 16.0 * f64::EPSILON {
            return refuse("an upward direction that is not along the view");
        }
        let half = (0.5 * field_of_view).tan();
        let right = right.normalize() * half;
        Ok(Self { position, forward, up: right.cross(forward), right })
    }

    /// The pinhole.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// The unit direction through a point of an image of `[width, height]` square pixels.
    ///
    /// `x` runs from 0 at the left edge to `width`, `y` from 0 at the upper edge to `height`, so that
    /// pixel (i, j) has its centre at (i + 1/2, j + 1/2). An image without height gives the middle.
    pub fn direction(&self, x: f64, y: f64, [width, height]: [usize; 2]) -> DVec3 {
        let (width, height) = (width as f64, height.max(1) as f64);
        let (across, upwards) = ((2.0 * x - width) / height, 1.0 - 2.0 * y / height);
        (self.forward + across * self.right + upwards * self.up).normalize()
    }
}
