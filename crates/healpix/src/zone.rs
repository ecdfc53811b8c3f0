use std::f64::consts::{FRAC_PI_2, PI};

use crate::azimuth::sin_series;

/// The |z| of the border between the caps, where meridians of the projection converge, and the
/// belt, where they are parallel.
pub(crate) const Z_BORDER: f64 = 2.0 / 3.0;

const SQRT_6: f64 = 2.449489742783178;

/// pi minus its `f64`, which preserves the digits of angles from the equator and the south pole.
const PI_REST: f64 = 1.2246467991473532e-16;

/// A colatitude, represented by the quantity that the projection needs and that keeps its digits in
/// the zone.
///
/// The cap distance `sqrt(3 (1 - |z|))` increases from 0 at the pole to 1 at the border of the
/// belt. It is never computed from `1 - |z|`, which loses half of the digits at 1e-8 from the pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Zone {
    /// `z > 2/3`: the distance to the north pole.
    North(f64),
    /// `|z| <= 2/3`: z itself.
    Belt(f64),
    /// `z < -2/3`: the distance to the south pole.
    South(f64),
}

impl Zone {
    /// Returns the zone of the unit vector `(x, y, z)`, using `1 - |z| = (x^2 + y^2)/(1 + |z|)`.
    #[inline]
    pub(crate) fn of_xyz(x: f64, y: f64, z: f64) -> Self {
        let abs_z = z.abs();
        if abs_z <= Z_BORDER {
            return Self::Belt(z);
        }
        let distance = cap_distance(x, y, abs_z);
        if z > 0.0 { Self::North(distance) } else { Self::South(distance) }
    }

    /// Returns the zone of `theta` in `[0, pi]`, using `1 - cos(theta) = 2 sin(theta/2)^2`.
    #[inline]
    pub(crate) fn of_theta(theta: f64) -> Self {
        let z = z_of_theta(theta);
        if z.abs() <= Z_BORDER {
            Self::Belt(z)
        } else if z > 0.0 {
            Self::North(cap_distance_of_theta(theta))
        } else {
            Self::South(cap_distance_of_theta(theta))
        }
    }

    /// Returns `(sin(theta), cos(theta))`.
    #[inline]
    pub(crate) fn sin_cos(self) -> (f64, f64) {
        match self {
            Self::Belt(z) => (((1.0 - z) * (1.0 + z)).sqrt(), z),
            Self::North(distance) => cap_sin_cos(distance),
            Self::South(distance) => {
                let (sin, cos) = cap_sin_cos(distance);
                (sin, -cos)
            }
        }
    }

    /// Returns the colatitude in radians, in `[0, pi]`.
    #[inline]
    pub(crate) fn theta(self) -> f64 {
        match self {
            Self::Belt(z) => z.acos(),
            Self::North(distance) => cap_angle(distance),
            Self::South(distance) => PI - cap_angle(distance),
        }
    }
}

/// Returns the cap distance of the unit vector `(x, y, z)`.
#[inline(always)]
pub(crate) fn cap_distance(x: f64, y: f64, abs_z: f64) -> f64 {
    (3.0 * (x * x + y * y) / (1.0 + abs_z)).sqrt()
}

/// Returns the cosine of `theta` in `[0, pi]`, with full relative precision in the belt and within
/// 5e-14 in the caps.
#[inline(always)]
pub(crate) fn z_of_theta(theta: f64) -> f64 {
    sin_series((FRAC_PI_2 - theta) + 0.5 * PI_REST)
}

/// Returns the cap distance of `theta` in `[0, pi]`, from the nearer pole.
#[inline(always)]
pub(crate) fn cap_distance_of_theta(theta: f64) -> f64 {
    let from_south = (PI - theta) + PI_REST;
    SQRT_6 * sin_series(0.5 * if theta < from_south { theta } else { from_south })
}

/// Returns `(sin, cos)` of the angle from the pole: `sin^2 = (1 - |z|)(1 + |z|)` with
/// `1 - |z| = d^2/3`.
#[inline]
fn cap_sin_cos(distance: f64) -> (f64, f64) {
    let below_pole = distance * distance / 3.0;
    (distance * ((2.0 - below_pole) / 3.0).sqrt(), 1.0 - below_pole)
}

#[inline]
fn cap_angle(distance: f64) -> f64 {
    2.0 * (distance / SQRT_6).asin()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns angles from the pole up to the border, dense near the pole.
    fn cap_angles() -> impl Iterator<Item = f64> {
        (0..=300).map(|k| Z_BORDER.acos() * 10.0_f64.powf(-f64::from(k)))
    }

    #[test]
    fn angle_and_vector_give_the_same_zone() {
        for angle in cap_angles().skip(1) {
            let (sin, cos) = angle.sin_cos();
            let (Zone::North(a), Zone::North(b)) =
                (Zone::of_theta(angle), Zone::of_xyz(sin, 0.0, cos))
            else {
                panic!("{angle} from the pole is not in the north cap");
            };
            // Below 1e-154 the square of the component underflows: the pole, to all digits of a
            // direction.
            let floor = 1e-150;
            assert!((a - b).abs() <= 4.0 * f64::EPSILON * a + floor, "{angle}: {a} against {b}");
        }
    }

    #[test]
    fn zone_keeps_the_relative_precision_of_small_angles() {
        for angle in cap_angles().skip(1) {
            let zone = Zone::of_theta(angle);
            let (sin, cos) = zone.sin_cos();
            let tolerance = 4.0 * f64::EPSILON;
            assert!((sin - angle.sin()).abs() <= tolerance * sin, "{angle}");
            assert!((cos - angle.cos()).abs() <= tolerance, "{angle}");
            assert!((zone.theta() - angle).abs() <= tolerance * angle, "{angle}");
        }
    }

    #[test]
    fn colatitudes_keep_their_digits_from_pole_to_pole() {
        const SAMPLES: u32 = 100_000;
        let even = (0..=SAMPLES).map(|k| PI * f64::from(k) / f64::from(SAMPLES));
        let near = (1..=16).flat_map(|k| {
            let offset = 10.0_f64.powi(-k);
            [FRAC_PI_2 - offset, FRAC_PI_2 + offset, PI - offset]
        });
        for theta in even.chain(near).chain([FRAC_PI_2]) {
            // The sine series, its argument, the factor and the library round once each, by half an
            // eps.
            let tolerance = 3.0 * f64::EPSILON;
            let (got, expected) = match Zone::of_theta(theta) {
                Zone::Belt(z) => (z, theta.cos()),
                Zone::North(distance) => (distance, SQRT_6 * (0.5 * theta).sin()),
                Zone::South(distance) => (distance, SQRT_6 * (0.5 * theta).cos()),
            };
            assert!(
                (got - expected).abs() <= tolerance * expected.abs(),
                "{theta}: {got} {expected}"
            );
        }
    }

    #[test]
    fn south_mirrors_north() {
        for distance in [0.0, 1e-12, 0.3, 1.0] {
            let (sin, cos) = Zone::North(distance).sin_cos();
            assert_eq!(Zone::South(distance).sin_cos(), (sin, -cos));
        }
        assert_eq!((Zone::North(0.0).theta(), Zone::South(0.0).theta()), (0.0, PI));
        assert_eq!(Zone::of_xyz(0.0, 0.0, -1.0), Zone::South(0.0));
    }
}
