use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, TAU};

use glam::DVec3;

use crate::concentric::concentric_polar;
use crate::polar::half_open;
use crate::{
    Measure, Support, Warp, WarpSample, concentric_disk, cosine_hemisphere, cosine_hemisphere_pdf,
};

/// Relative rounding error of lengths, for tests of boundaries.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Uniform points (x, y, 0) of the unit disk, by [`concentric_disk`].
///
/// The map is not smooth on the diagonals of the square. Round trips are accurate to 1e-15.
///
/// # References
///
/// Shirley and Chiu 1997.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConcentricDisk;

/// Directions of density cos(theta)/pi on the hemisphere z >= 0, by [`cosine_hemisphere`].
///
/// The map is not smooth on the diagonals of the square. Round trips are accurate to 1e-15.
///
/// # References
///
/// Shirley and Chiu 1997; Malley 1988.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CosineHemisphere;

/// Uniform directions of the hemisphere z >= 0, by the concentric map to the disk of radius r,
/// lifted to z = 1 - r^2 (Lambert's equal-area projection).
///
/// Up to a rotation of the square by 45 degrees it is the upper half of
/// [`OctahedralSphere`](crate::OctahedralSphere). Unlike
/// [`UniformCap::HEMISPHERE`](crate::UniformCap::HEMISPHERE) it is continuous at the pole and in
/// longitude. The map is not smooth on the diagonals of the square. Round trips are accurate to
/// 1e-15.
///
/// # References
///
/// Shirley and Chiu 1997; Clarberg 2008.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConcentricHemisphere;

/// Returns the point of the square that the concentric map assigns to (x, y), of length at most 1.
fn concentric_inverse(x: f64, y: f64) -> [f64; 2] {
    let r = x.hypot(y);
    let (a, b) = if x.abs() > y.abs() {
        let a = r.copysign(x);
        (a, 2.0 * FRAC_2_PI * a * (y / x).atan())
    } else if y == 0.0 {
        (0.0, 0.0)
    } else {
        let b = r.copysign(y);
        (2.0 * FRAC_2_PI * b * (x / y).atan(), b)
    };
    [half_open(0.5 * (1.0 + a)), half_open(0.5 * (1.0 + b))]
}

/// Returns where the diagonals meet the line of constant u.
fn diagonals(u: f64) -> Vec<f64> {
    let mut breaks = vec![u.min(1.0 - u), u.max(1.0 - u)];
    breaks.retain(|v| *v > 0.0 && *v < 1.0);
    breaks.dedup();
    breaks
}

impl Warp for ConcentricDisk {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        WarpSample { point: concentric_disk(u, v).extend(0.0), density: FRAC_1_PI }
    }

    fn density(&self, point: DVec3) -> f64 {
        if point.x.hypot(point.y) <= 1.0 + ROUNDING { FRAC_1_PI } else { 0.0 }
    }

    fn inverse(&self, point: DVec3) -> Option<[f64; 2]> {
        (self.density(point) > 0.0).then(|| concentric_inverse(point.x, point.y))
    }

    fn measure(&self) -> Measure {
        Measure::DiskArea
    }

    fn support(&self) -> Support {
        Support::Disk
    }

    fn min_density(&self) -> f64 {
        FRAC_1_PI
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        vec![0.5]
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        diagonals(u)
    }
}

impl Warp for CosineHemisphere {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let point = cosine_hemisphere(u, v);
        WarpSample { point, density: cosine_hemisphere_pdf(point) }
    }

    fn density(&self, dir: DVec3) -> f64 {
        cosine_hemisphere_pdf(dir)
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        (dir.z >= 0.0).then(|| concentric_inverse(dir.x, dir.y))
    }

    fn support(&self) -> Support {
        Support::UpperHemisphere
    }

    fn min_density(&self) -> f64 {
        0.0
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        vec![0.5]
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        diagonals(u)
    }
}

impl Warp for ConcentricHemisphere {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let (r, phi) = concentric_polar(u, v);
        let (sin, cos) = phi.sin_cos();
        let sin_theta = r * (2.0 - r * r).sqrt();
        let z = (1.0 - r) * (1.0 + r);
        WarpSample { point: DVec3::new(sin_theta * cos, sin_theta * sin, z), density: 1.0 / TAU }
    }

    fn density(&self, dir: DVec3) -> f64 {
        if dir.z >= 0.0 { 1.0 / TAU } else { 0.0 }
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let scale = (1.0 + dir.z).sqrt();
        (dir.z >= 0.0).then(|| concentric_inverse(dir.x / scale, dir.y / scale))
    }

    fn support(&self) -> Support {
        Support::UpperHemisphere
    }

    fn min_density(&self) -> f64 {
        1.0 / TAU
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        vec![0.5]
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        diagonals(u)
    }
}
