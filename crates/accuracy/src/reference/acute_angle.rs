use std::f64::consts::FRAC_PI_2;

use super::DoubleDouble;

/// The angle to the nearer pole in twice the working precision, and which pole that is.
#[derive(Clone, Copy, Debug)]
pub struct AcuteAngle {
    /// The sine.
    pub sin: DoubleDouble,
    /// One minus the cosine.
    pub versine: DoubleDouble,
    /// Whether the nearer pole is the southern one.
    pub south: bool,
}

impl AcuteAngle {
    /// Returns the angle of a colatitude in `[0, PI]`, radians, taken as the exact number that the
    /// `f64` is.
    #[must_use]
    pub fn from_theta(theta: f64) -> Self {
        let south = theta > FRAC_PI_2;
        let angle = if south { DoubleDouble::supplement(theta) } else { DoubleDouble::from(theta) };
        let (half_sin, half_cos) = angle.shifted(-1).sin_cos();
        Self {
            sin: (half_sin * half_cos).shifted(1),
            versine: (half_sin * half_sin).shifted(1),
            south,
        }
    }

    /// Returns the angle of a direction `(x, y, z)`, of any length but zero, taken as the exact
    /// numbers that the `f64` are.
    #[must_use]
    pub fn from_direction([x, y, z]: [f64; 3]) -> Self {
        let south = z < 0.0;
        let [x, y, z] = [x, y, z.abs()].map(DoubleDouble::from);
        let across = x * x + y * y;
        let length = (across + z * z).sqrt();
        Self { sin: across.sqrt() / length, versine: across / (length * (length + z)), south }
    }
}
