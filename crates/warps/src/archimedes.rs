use glam::DVec3;

/// Returns the direction at height z = 1 - `drop` and longitude `phi` (radians), for `drop` in
/// [0, 2]: Archimedes' area-preserving map from the enclosing cylinder to the sphere.
///
/// The distance from the tangent plane at the north pole, instead of z, gives sin(theta) full
/// relative precision at the north pole; at the south pole sin(theta) is as accurate as 2 - `drop`.
///
/// # Examples
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
