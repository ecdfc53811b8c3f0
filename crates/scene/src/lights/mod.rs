//! Environment maps as directional lights, and the error of the irradiance that these cast.

pub(crate) mod adapted;
pub(crate) mod environment;
pub(crate) mod gram;
pub(crate) mod irradiance;
pub(crate) mod median_cut;

use glam::DVec3;

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
    /// Returns the irradiance of a surface with this normal, which faces away at `normal . direction
    /// < 0`.
    #[must_use]
    pub fn on_surface(&self, normal: DVec3) -> [f64; 3] {
        let cosine = normal.dot(self.direction).max(0.0);
        self.irradiance.map(|x| x * cosine)
    }
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
