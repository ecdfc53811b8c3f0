//! The map of Archimedes: the cylinder around the sphere onto the sphere, which keeps areas.

use glam::DVec3;

/// The direction at height z = 1 - `drop` and longitude `phi` (radians), for `drop` in [0, 2].
///
/// Taking the distance to the north pole's plane instead of z keeps full relative precision of
/// sin(theta) at the pole where patterns begin; at the south pole sin(theta) is as good as
/// 2 - `drop` is.
pub(crate) fn direction(drop: f64, phi: f64) -> DVec3 {
    let sin_theta = (drop * (2.0 - drop)).sqrt();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - drop)
}
