//! Directions from angles in degrees, exact at the poles and on the axes.

use glam::DVec3;

/// Returns the direction of a longitude and a latitude in degrees.
///
/// ```text
/// (cos lat cos lon, cos lat sin lon, sin lat)
/// ```
///
/// Any finite longitude is valid. At multiples of 90 degrees the coordinates are exactly 0 or 1 in
/// size, and near the poles `cos lat` keeps its relative accuracy.
pub(super) fn direction_of_degrees(lon: f64, lat: f64) -> DVec3 {
    let (sin_lon, cos_lon) = sin_cos_degrees(lon);
    let (sin_lat, cos_lat) = sin_cos_degrees(lat);
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Returns the direction of a colatitude and a longitude in radians.
pub(super) fn direction_of_radians(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Returns sine and cosine of an angle in degrees.
///
/// The remainder by 360 and the distance to the next multiple of 90 are exact in floating point, so
/// the only errors are those of one product with pi/180 and of `sin_cos` on [-pi/4, pi/4].
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let wrapped = degrees % 360.0;
    let quarter = (wrapped / 90.0).round();
    let (sin, cos) = (wrapped - 90.0 * quarter).to_radians().sin_cos();
    // `wrapped` lies in (-360, 360), so `quarter` is one of -4..=4.
    match quarter.rem_euclid(4.0) {
        1.0 => (cos, -sin),
        2.0 => (-sin, -cos),
        3.0 => (-cos, sin),
        _ => (sin, cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_exact() {
        let cases = [
            (0.0, 0.0, DVec3::X),
            (90.0, 0.0, DVec3::Y),
            (-90.0, 0.0, DVec3::NEG_Y),
            (270.0, 0.0, DVec3::NEG_Y),
            (180.0, 0.0, DVec3::NEG_X),
            (-180.0, 0.0, DVec3::NEG_X),
            (360.0, 0.0, DVec3::X),
            (-3600.0, 0.0, DVec3::X),
            (12.3, 90.0, DVec3::Z),
            (-77.7, -90.0, DVec3::NEG_Z),
        ];
        for (lon, lat, expected) in cases {
            let got = direction_of_degrees(lon, lat);
            assert_eq!(got, expected, "lon {lon}, lat {lat}");
        }
    }

    #[test]
    fn agrees_with_radians_away_from_the_axes() {
        for k in -400..400 {
            let degrees = f64::from(k) * 1.37;
            let (sin, cos) = sin_cos_degrees(degrees);
            let (sin_r, cos_r) = degrees.to_radians().sin_cos();
            // The direct computation rounds an angle of up to 9.6 rad: half an ulp of it is 4
            // EPSILON.
            let tolerance = 8.0 * f64::EPSILON;
            assert!((sin - sin_r).abs() <= tolerance, "{degrees}: {sin} against {sin_r}");
            assert!((cos - cos_r).abs() <= tolerance, "{degrees}: {cos} against {cos_r}");
        }
    }

    #[test]
    fn cosine_near_the_pole_keeps_its_digits() {
        // 90 - 2^-40 degrees is a floating-point number; its cosine is sin(2^-40 degrees).
        let small = 2f64.powi(-40);
        let exact = small.to_radians().sin();
        let got = direction_of_degrees(0.0, 90.0 - small).x;
        // One rounding in the product and one in the sine.
        assert!((got - exact).abs() <= 2.0 * f64::EPSILON * exact, "{got:e} against {exact:e}");
    }
}
