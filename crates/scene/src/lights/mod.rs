//! Environment maps as directional lights, and the error of the irradiance that these cast.

mod cells;
pub(crate) mod environment;
mod gram;
pub(crate) mod irradiance;
mod median_cut;

use glam::DVec3;
use rayon::prelude::*;

/// A light at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// The unit vector towards the light.
    pub direction: DVec3,
    /// The irradiance of a surface that faces the light, in red, green and blue: an integral of
    /// radiance over solid angle.
    pub irradiance: [f64; 3],
}

impl DirectionalLight {
    /// Returns the irradiance of a surface with this normal, 0 if it faces away.
    #[must_use]
    pub fn on_surface(&self, normal: DVec3) -> [f64; 3] {
        let cosine = normal.dot(self.direction).max(0.0);
        self.irradiance.map(|x| x * cosine)
    }
}

/// Returns the irradiance of surfaces with these normals under several lights.
///
/// Cost: 2 ns for each normal and light.
#[must_use]
pub fn irradiance_of(lights: &[DirectionalLight], normals: &[DVec3]) -> Vec<[f64; 3]> {
    let of_normal = |&normal: &DVec3| {
        lights.iter().fold([0.0; 3], |sum, light| {
            let of_light = light.on_surface(normal);
            [0, 1, 2].map(|c| sum[c] + of_light[c])
        })
    };
    normals.par_iter().map(of_normal).collect()
}

/// Returns the luminance of a linear colour (ITU-R BT.709).
#[must_use]
pub fn luminance(colour: [f64; 3]) -> f64 {
    dot(LUMINANCE, colour)
}

/// The weights of red, green and blue.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
