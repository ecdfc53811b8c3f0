use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

use glam::DVec3;

use crate::polar::half_open;
use crate::{Support, Warp, WarpSample};

/// The density of the uniform sphere.
const DENSITY: f64 = 0.25 / PI;

/// Uniform directions of the sphere by the equal-area octahedral map: +z is the middle of the
/// square, -z its corners, x points along u, y along v.
///
/// With a = 2u - 1, b = 2v - 1 and r = 1 - |1 - |a| - |b||,
///
/// ```text
/// |z| = 1 - r^2,   z > 0 where |a| + |b| < 1,   phi = (pi/4) (1 + (|b| - |a|)/r)
/// ```
///
/// in the first quadrant, reflected into the others. The map is continuous, and each edge of the
/// square is joined to its own other half. It is not smooth on the lines a = 0, b = 0 and
/// |a| + |b| = 1. Round trips are accurate to 1e-15.
///
/// # Examples
///
/// ```
/// use sphvar_warps::{OctahedralSphere, Warp};
/// assert_eq!(OctahedralSphere.map([0.5, 0.5]), glam::DVec3::Z);
/// ```
///
/// # References
///
/// Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere using SIMD".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctahedralSphere;

impl Warp for OctahedralSphere {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let sum = a.abs() + b.abs();
        // The second form is exact at the corners.
        let r = if sum <= 1.0 { sum } else { (1.0 - a.abs()) + (1.0 - b.abs()) };
        let share = if r > 0.0 { 0.5 + 0.5 * (b.abs() - a.abs()) / r } else { 0.5 };
        let (sin, cos) = (FRAC_PI_2 * share).sin_cos();
        let drop = r * r;
        let z = (1.0 - r) * (1.0 + r);
        let sin_theta = r * (2.0 - drop).sqrt();
        let point = DVec3::new(
            (sin_theta * cos).copysign(a),
            (sin_theta * sin).copysign(b),
            if sum <= 1.0 { z } else { -z },
        );
        WarpSample { point, density: DENSITY }
    }

    fn density(&self, _: DVec3) -> f64 {
        DENSITY
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let r = ((dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z.abs())).sqrt();
        let b = FRAC_2_PI * dir.y.abs().atan2(dir.x.abs()) * r;
        let a = r - b;
        let (a, b) = if dir.z >= 0.0 { (a, b) } else { (1.0 - b, 1.0 - a) };
        let coordinate = |x: f64, sign: f64| half_open(0.5 * (1.0 + x.copysign(sign)));
        Some([coordinate(a, dir.x), coordinate(b, dir.y)])
    }

    fn support(&self) -> Support {
        Support::Sphere
    }

    fn min_density(&self) -> f64 {
        DENSITY
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        vec![0.5]
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        let half = 0.5 * (1.0 - (2.0 * u - 1.0).abs());
        let inside = |v: &f64| *v > 0.0 && *v < 1.0;
        let mut breaks: Vec<f64> =
            [0.5 - half, 0.5, 0.5 + half].into_iter().filter(inside).collect();
        breaks.dedup();
        breaks
    }
}
