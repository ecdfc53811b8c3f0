use std::f64::consts::{FRAC_PI_8, TAU};

use glam::DVec3;
use sphvar_nufft::parts::{LANES, Places, Real, Turns, interpolate};

const DEGREE: usize = 12;

/// Angles of plane vectors by a polynomial that the compiler can vectorize.
#[derive(Clone, Debug)]
pub(crate) struct Angles {
    /// Coefficients of `atan(u)/u` in turns, as a polynomial in t with
    /// `u^2 = (t + 1)/2 tan^2(pi/8)`.
    coefficients: [f64; DEGREE + 1],
}

/// Directions, or vectors along them, as places on a grid: theta by row, phi by column.
pub(crate) struct Directions<'a> {
    pub(crate) angles: &'a Angles,
    pub(crate) points: &'a [DVec3],
}

impl Places for Directions<'_> {
    fn count(&self) -> usize {
        self.points.len()
    }

    #[inline(always)]
    fn turns<const FUSED: bool>(&self, first: usize) -> [Turns; 2] {
        let mut coordinates = [[0.0; LANES]; 3];
        let points = &self.points[first..self.points.len().min(first + LANES)];
        for (i, p) in points.iter().enumerate() {
            (coordinates[0][i], coordinates[1][i], coordinates[2][i]) = (p.x, p.y, p.z);
        }
        let [x, y, z] = coordinates;
        let mut rho = [0.0; LANES];
        for i in 0..LANES {
            rho[i] = (x[i] * x[i] + y[i] * y[i]).sqrt();
        }
        let phi = self.angles.of::<FUSED>(&x, &y);
        let theta = self.angles.of::<FUSED>(&z, &rho);
        [theta, phi]
    }
}

impl Angles {
    pub(crate) fn new() -> Self {
        let limit = FRAC_PI_8.tan();
        let ratio = |t: f64| {
            let u = limit * (0.5 * (t + 1.0)).sqrt();
            // (atan(u)/u - 1)/u^2 = -1/3 + u^2/5 - ..., without the cancellation of the left side.
            -(0..40).rev().fold(0.0, |sum, k| 1.0 / f64::from(2 * k + 3) - u * u * sum) / TAU
        };
        // atan is analytic up to u^2 = -1: the coefficients decrease by a factor of 25 per degree.
        let fitted = interpolate(ratio, DEGREE);
        Self { coefficients: std::array::from_fn(|i| fitted[i]) }
    }

    /// Returns the angles of the vectors (x, y), in [0, 1] turns; 0 for the zero vector.
    #[inline(always)]
    pub(crate) fn of<const FUSED: bool>(&self, x: &[f64; LANES], y: &[f64; LANES]) -> Turns {
        let limit = FRAC_PI_8.tan();
        let scale = 2.0 / (limit * limit);
        let mut turns = Turns::default();
        for i in 0..LANES {
            let (ax, ay) = (x[i].abs(), y[i].abs());
            let (low, high) = if ay > ax { (ax, ay) } else { (ay, ax) };
            // Beyond pi/8 the angle is computed relative to pi/4: atan u - pi/4 = atan((u - 1)/(u +
            // 1)).
            let beyond = low > limit * high;
            let (over, under) = if beyond { (low - high, low + high) } else { (low, high) };
            let u = over / if under > 0.0 { under } else { 1.0 };
            let t = (u * u).times_plus::<FUSED>(scale, -1.0);
            let mut sum = 0.0_f64;
            for &c in &self.coefficients {
                sum = sum.times_plus::<FUSED>(t, c);
            }
            let rest = u.times_plus::<FUSED>(1.0 / TAU, sum * (u * u) * u);
            let eighths = if beyond { 1.0 } else { 0.0 };
            let (eighths, rest) = if ay > ax { (2.0 - eighths, -rest) } else { (eighths, rest) };
            let (eighths, rest) = if x[i] < 0.0 { (4.0 - eighths, -rest) } else { (eighths, rest) };
            let (eighths, rest) = if y[i] < 0.0 { (8.0 - eighths, -rest) } else { (eighths, rest) };
            turns.eighths[i] = eighths;
            turns.rest[i] = rest;
        }
        turns
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use sphvar_nufft::parts::LANES;

    use super::Angles;

    #[test]
    fn angles_match_atan2() {
        let angles = Angles::new();
        let special = [0.0, -0.0, 1e-300, -1e-300, 1e-9, 0.5, -0.5, 1.0, -1.0, 0.4142, 0.4143];
        let round = (0..2000).map(|k| (f64::from(k) * 0.01234).sin_cos());
        let pairs = special.into_iter().flat_map(|x| special.map(|y| (x, y))).chain(round);
        for (x, y) in pairs {
            let turns = angles.of::<true>(&[x; LANES], &[y; LANES]);
            let (eighths, rest) = (turns.eighths[3], turns.rest[3]);
            assert!((0.0..=8.0).contains(&eighths) && rest.abs() <= 0.0626, "({x}, {y})");
            let got = eighths / 8.0 + rest;
            assert!((0.0..=1.0).contains(&got), "({x}, {y}): {got} turns");
            let expected = (y + 0.0).atan2(x + 0.0) / TAU;
            let difference = got - expected;
            // atan2 and the sum round at 1/2 turn, to EPSILON/4 each.
            let off = (difference - difference.round()).abs();
            assert!(off <= f64::EPSILON, "({x}, {y}): {got} instead of {expected}");
        }
    }
}
