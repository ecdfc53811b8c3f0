use glam::DVec3;

/// Returns the direction at height z = 1 - `drop` and longitude `phi` (radians), for `drop` in [0, 2]: the map of Archimedes
/// from the cylinder around the sphere, which keeps areas.
///
/// Taking the distance to the north pole's plane instead of z keeps full relative precision of
/// sin(theta) at the pole where patterns begin; at the south pole sin(theta) is as good as
/// 2 - `drop` is.
///
/// ```
/// use sphvar_warps::archimedes;
/// assert_eq!(archimedes(0.0, 1.0), glam::DVec3::Z);
/// ```
#[must_use]
#[inline]
pub fn archimedes(drop: f64, phi: f64) -> DVec3 {
    let sin_theta = (drop * (2.0 - drop)).sqrt();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - drop)
}
