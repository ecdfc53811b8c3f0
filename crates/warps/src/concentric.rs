use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3};

/// Returns the point of the unit disk that the concentric map assigns to (u, v) in [0, 1]^2.
///
/// Concentric squares map to concentric circles: with a = 2u - 1, b = 2v - 1,
///
/// ```text
/// r = a, phi = (pi/4) b/a            where |a| > |b|,
/// r = b, phi = pi/2 - (pi/4) a/b     elsewhere; the centre is fixed.
/// ```
///
/// The map preserves areas up to the factor pi. It is continuous and bijective, unlike the map by
/// polar coordinates.
///
/// # Examples
///
/// ```
/// use sphvar_warps::concentric_disk;
/// assert!((concentric_disk(1.0, 1.0).length() - 1.0).abs() < 1e-15);
/// assert_eq!(concentric_disk(0.5, 0.5).length(), 0.0);
/// ```
///
/// # References
///
/// Shirley and Chiu 1997.
#[must_use]
pub fn concentric_disk(u: f64, v: f64) -> DVec2 {
    let (r, phi) = concentric_polar(u, v);
    let (sin, cos) = phi.sin_cos();
    DVec2::new(r * cos, r * sin)
}

/// Returns the direction of the hemisphere z >= 0 above [`concentric_disk`]`(u, v)`. For (u, v)
/// uniform in [0, 1]^2, its density is [`cosine_hemisphere_pdf`] (Malley's method).
///
/// # Examples
///
/// ```
/// use sphvar_warps::cosine_hemisphere;
/// assert_eq!(cosine_hemisphere(0.5, 0.5), glam::DVec3::Z);
/// ```
#[must_use]
pub fn cosine_hemisphere(u: f64, v: f64) -> DVec3 {
    let (r, phi) = concentric_polar(u, v);
    let (sin, cos) = phi.sin_cos();
    // |r| <= 1: the product is never negative and keeps its digits at the rim.
    DVec3::new(r * cos, r * sin, ((1.0 - r) * (1.0 + r)).sqrt())
}

/// Returns the density of [`cosine_hemisphere`] at the unit vector `dir`, per steradian:
/// cos(theta)/pi for z >= 0, otherwise 0.
#[must_use]
pub fn cosine_hemisphere_pdf(dir: DVec3) -> f64 {
    dir.z.max(0.0) * FRAC_1_PI
}

/// Returns the signed radius and the angle of the concentric map.
pub(crate) fn concentric_polar(u: f64, v: f64) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b.abs() > 0.0 {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::{concentric_disk, cosine_hemisphere};

    #[test]
    fn squares_map_to_circles_of_the_same_relative_area() {
        for half in [1e-300, 1e-9, 0.125, 0.25, 0.5] {
            for t in [-1.0, -0.7, 0.0, 0.3, 1.0] {
                let (near, far) = (0.5 + t * half, 0.5 + half);
                for (u, v) in [(far, near), (near, far), (1.0 - far, near), (near, 1.0 - far)] {
                    let r = concentric_disk(u, v).length();
                    let expected = (2.0 * u - 1.0).abs().max((2.0 * v - 1.0).abs());
                    assert!((r - expected).abs() < 2.0 * f64::EPSILON, "({u}, {v}) at radius {r}");
                }
            }
        }
    }

    /// The Jacobian, by central differences, is pi everywhere except on the diagonals.
    #[test]
    fn the_concentric_map_preserves_areas() {
        const H: f64 = 1e-5;
        for (u, v) in [(0.9, 0.3), (0.6, 0.95), (0.1, 0.45), (0.4, 0.02), (0.51, 0.503)] {
            let du = (concentric_disk(u + H, v) - concentric_disk(u - H, v)) / (2.0 * H);
            let dv = (concentric_disk(u, v + H) - concentric_disk(u, v - H)) / (2.0 * H);
            // Differences: (H/r)^2 with r >= 0.02, and EPSILON/H.
            assert!((du.perp_dot(dv) - PI).abs() < 1e-5, "({u}, {v}): {}", du.perp_dot(dv));
        }
    }

    #[test]
    fn the_rim_lies_on_the_equator() {
        for (u, v) in [(0.0, 0.0), (1.0, 0.2), (0.5, 1.0), (0.0, 1.0), (1.0, 1.0)] {
            let p = cosine_hemisphere(u, v);
            assert!(p.z.abs() <= 0.0, "({u}, {v}) gave {p}");
            assert!((p.length() - 1.0).abs() < 1e-15, "({u}, {v}) gave {p}");
        }
    }
}
