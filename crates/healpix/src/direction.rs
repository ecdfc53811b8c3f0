use glam::DVec3;

use crate::Error;

/// Returns the unit vector along `v`. Infallible lookups require only this check of untrusted
/// vectors.
///
/// The vector is scaled first, so that squares neither overflow for 1e300 nor underflow for 1e-300.
///
/// # Errors
///
/// [`Error::NoDirection`] if `v` is zero or has an infinite or NaN component.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_healpix::unit_direction;
///
/// assert_eq!(unit_direction(DVec3::new(0.0, 3e300, 4e300))?, DVec3::new(0.0, 0.6, 0.8));
/// assert!(unit_direction(DVec3::ZERO).is_err());
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
pub fn unit_direction(v: DVec3) -> Result<DVec3, Error> {
    let scale = v.abs().max_element();
    // `max_element` may ignore NaN, so the vector itself is checked.
    if !v.is_finite() || scale == 0.0 {
        return Err(Error::NoDirection { x: v.x, y: v.y, z: v.z });
    }
    let scaled = v / scale;
    Ok(scaled / scaled.length())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_is_accepted() {
        for length in [5e-324, 1e-310, 1e-200, 1.0, 1e200, f64::MAX] {
            let dir = unit_direction(DVec3::new(length, 0.0, -length)).unwrap();
            let expected = DVec3::new(0.5_f64.sqrt(), 0.0, -0.5_f64.sqrt());
            // The quotient, the square root and the second quotient round once each.
            assert!(dir.distance(expected) <= 2.0 * f64::EPSILON, "{length}: {dir}");
        }
    }

    #[test]
    fn vectors_without_direction_are_rejected() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for v in
                [DVec3::new(bad, 0.0, 1.0), DVec3::new(0.0, bad, 1.0), DVec3::new(1.0, 0.0, bad)]
            {
                assert!(unit_direction(v).is_err(), "{v}");
            }
        }
        assert!(unit_direction(DVec3::new(-0.0, 0.0, 0.0)).is_err());
    }
}
