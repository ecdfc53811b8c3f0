use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use crate::{Bounds, Error};

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
    /// Half the image's height at distance 1, in the upward direction and to the right.
    up: DVec3,
    right: DVec3,
}

impl Camera {
    /// Returns a camera at `position` with `target` at the centre of its image.
    ///
    /// `up` appears upwards; it need be neither of unit length nor perpendicular to the view.
    /// `field_of_view` is the angle between the lower and the upper edge in radians, in (0, pi).
    ///
    /// # Errors
    ///
    /// Returns [`Error::Camera`] if a number is not finite, the target is at the position, `up` is
    /// along the view, or the angle is out of range.
    pub fn look_at(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        field_of_view: f64,
    ) -> Result<Self, Error> {
        let reject = |expected| Err(Error::Camera { expected });
        if !position.is_finite() || !target.is_finite() || !up.is_finite() {
            return reject("finite coordinates");
        }
        check_angle(field_of_view)?;
        let Some(forward) = (target - position).try_normalize() else {
            return reject("a target that differs from its position");
        };
        let Some(up) = up.try_normalize() else { return reject("an upward direction") };
        // Rounding alone leaves about one EPSILON of a parallel direction.
        let right = forward.cross(up);
        if right.length() < 16.0 * f64::EPSILON {
            return reject("an upward direction that is not along the view");
        }
        let half = (0.5 * field_of_view).tan();
        let right = right.normalize() * half;
        Ok(Self { position, forward, up: right.cross(forward), right })
    }

    /// Returns a camera above and in front of `target`, which is at the centre of its image. Its
    /// distance is such that a ball about the target, with the diagonal of `bounds` as its
    /// diameter, fills the height of the image.
    ///
    /// `up` and `field_of_view` are those of [`Self::look_at`]; in front is positive z where `up`
    /// is y.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::look_at`]; for bounds without extent the target coincides with
    /// the position.
    pub fn around(
        bounds: &Bounds,
        target: DVec3,
        up: DVec3,
        field_of_view: f64,
    ) -> Result<Self, Error> {
        check_angle(field_of_view)?;
        let radius = 0.5 * (bounds.max - bounds.min).length();
        let tilt = DQuat::from_rotation_arc(DVec3::Y, up.try_normalize().unwrap_or(DVec3::Y));
        let towards = tilt * DVec3::new(0.5, 0.45, 1.0).normalize();
        let position = target + towards * (radius / (0.5 * field_of_view).sin());
        Self::look_at(position, target, up, field_of_view)
    }

    /// Returns the angle between the lower and the upper edge of the image in radians.
    #[must_use]
    pub fn field_of_view(&self) -> f64 {
        2.0 * self.up.length().atan()
    }

    /// Returns the position of the pinhole.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Returns the unit direction through a point of an image of `[width, height]` square pixels.
    ///
    /// `x` runs from 0 at the left edge to `width`, `y` from 0 at the upper edge to `height`, so
    /// that pixel (i, j) has its centre at (i + 1/2, j + 1/2). For an image without height the
    /// direction is that of the centre.
    pub fn direction(&self, x: f64, y: f64, [width, height]: [usize; 2]) -> DVec3 {
        let (width, height) = (width as f64, height.max(1) as f64);
        let (across, upwards) = ((2.0 * x - width) / height, 1.0 - 2.0 * y / height);
        (self.forward + across * self.right + upwards * self.up).normalize()
    }
}

fn check_angle(field_of_view: f64) -> Result<(), Error> {
    if field_of_view > 0.0 && field_of_view < PI {
        return Ok(());
    }
    Err(Error::Camera { expected: "a field of view above 0 and below 180 degrees" })
}

#[cfg(test)]
mod tests {
    use super::{Bounds, Camera, DVec3, PI};

    #[test]
    fn a_ball_around_the_bounds_fills_the_height() {
        let bounds = Bounds { min: DVec3::new(-1.0, 2.0, 0.5), max: DVec3::new(3.0, 2.5, 7.0) };
        let radius = 0.5 * DVec3::new(4.0, 0.5, 6.5).length();
        for up in [DVec3::Y, DVec3::NEG_Y, 3.0 * DVec3::Z, DVec3::new(1.0, -2.0, 0.3)] {
            for fov in [1e-3, 0.7, 3.1] {
                let camera = Camera::around(&bounds, bounds.center(), up, fov).unwrap();
                // The tangent of half the angle and its inverse have several roundings each; near
                // pi those of the tangent are magnified.
                let rounding = 64.0 * f64::EPSILON / (PI - fov);
                assert!((camera.field_of_view() / fov - 1.0).abs() < rounding, "{up} {fov}");
                let offset = bounds.center() - camera.position();
                let middle = camera.direction(1.5, 1.5, [3, 3]);
                assert!(middle.distance(offset.normalize()) < 1e-12, "{up} {fov}");
                // The upper edge touches the ball.
                let edge = camera.direction(1.5, 0.0, [3, 3]);
                let distance = edge.cross(offset).length();
                // Roundings of the directions are multiplied by the camera's distance.
                let rounding = 64.0 * f64::EPSILON * (1.0 + offset.length() / radius);
                assert!((distance / radius - 1.0).abs() < rounding, "{up} {fov}: {distance}");
                assert!(offset.dot(up) < 0.0, "it looks down: {up} {fov}");
            }
        }
        for fov in [0.0, -1.0, PI, f64::NAN, f64::INFINITY] {
            let error = Camera::around(&bounds, bounds.center(), DVec3::Y, fov).unwrap_err();
            assert!(error.to_string().contains("field of view"), "{fov}: {error}");
        }
        Camera::around(&bounds, bounds.center(), DVec3::ZERO, 1.0).unwrap_err();
        let point = Bounds { min: DVec3::ONE, max: DVec3::ONE };
        Camera::around(&point, DVec3::ONE, DVec3::Y, 1.0).unwrap_err();
    }
}
