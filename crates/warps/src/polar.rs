//! Directions by distance from the plane z = 1 and by longitude.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

/// Relative rounding error of `1 - z` of a unit vector, for tests of boundaries.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Returns `x` limited to [0, 1): a coordinate that rounding may have moved out of the square.
pub(crate) fn half_open(x: f64) -> f64 {
    x.clamp(0.0, 1.0 - 0.5 * f64::EPSILON)
}

/// Returns 1 - z of a unit vector, with full relative accuracy at the north pole.
pub(crate) fn drop_from_pole(dir: DVec3) -> f64 {
    if dir.z > 0.0 { (dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z) } else { 1.0 - dir.z }
}

/// Returns whether a distance from the plane z = 1 is within a cap of this height, to rounding.
pub(crate) fn is_within(drop: f64, height: f64) -> bool {
    drop <= height * (1.0 + ROUNDING)
}

/// Returns the longitude of a direction in turns, in [0, 1).
pub(crate) fn turns(dir: DVec3) -> f64 {
    let turns = 0.5 * FRAC_1_PI * dir.y.atan2(dir.x);
    half_open(if turns < 0.0 { turns + 1.0 } else { turns })
}

/// Returns the direction with height z = 1 - `drop`, both given so that each keeps its digits, at a
/// longitude in turns.
pub(crate) fn direction(drop: f64, z: f64, turns: f64) -> DVec3 {
    let sin_theta = (drop * (1.0 + z)).sqrt();
    let (sin, cos) = (TAU * turns).sin_cos();
    DVec3::new(sin_theta * cos, sin_theta * sin, z)
}
