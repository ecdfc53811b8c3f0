use core::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::Error;

/// `pi - PI`: the remainder of the `f64` nearest to pi.
const PI_TAIL: f64 = 1.224646799147353177e-16;

/// A colatitude in a representation that keeps its digits at both poles.
///
/// ```text
/// theta' = min(theta, pi - theta),   versine = 1 - cos theta' = 2 sin^2(theta'/2)
/// ```
///
/// The associated Legendre functions are evaluated at `theta'` from the versine; the southern
/// hemisphere follows by parity, `lambda_lm(pi - theta) = (-1)^(l + m) lambda_lm(theta)`. The
/// variable `cos theta` would not distinguish colatitudes below `1e-8` and would lose a factor
/// `1/sin theta` of accuracy.
///
/// # Examples
///
/// ```
/// use sphvar_sh::Colatitude;
///
/// let c = Colatitude::from_theta(1e-12)?;
/// assert!((c.versine() - 0.5e-24).abs() < 1e-39);
/// let south = Colatitude::from_theta(std::f64::consts::PI)?;
/// assert!(south.is_south());
/// assert_eq!(south.sin(), 1.2246467991473532e-16); // the f64 nearest to pi is not pi
/// assert!(Colatitude::from_theta(-1.0).is_err());
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colatitude {
    versine: f64,
    sin: f64,
    cos: f64,
    south: bool,
}

impl Colatitude {
    /// Returns the colatitude `theta`, in radians, in the closed interval `[0, PI]`.
    ///
    /// `sin` and `versine` have a relative error of about one `EPSILON`. In the south `pi - theta`
    /// is computed as `(PI - theta) + tail`: the difference is exact, and the tail of pi is
    /// included to first order.
    ///
    /// # Errors
    ///
    /// [`Error::Colatitude`] if `theta` is NaN or outside `[0, PI]`.
    pub fn from_theta(theta: f64) -> Result<Self, Error> {
        if !(0.0..=PI).contains(&theta) {
            return Err(Error::Colatitude { theta });
        }
        let south = theta > FRAC_PI_2;
        let (acute, tail) = if south { (PI - theta, PI_TAIL) } else { (theta, 0.0) };
        let (s, c) = acute.sin_cos();
        let (half_s, half_c) = (0.5 * acute).sin_cos();
        let half = half_s + 0.5 * tail * half_c;
        Ok(Self { versine: 2.0 * half * half, sin: s + tail * c, cos: c - tail * s, south })
    }

    /// Returns the colatitude of a unit vector.
    ///
    /// ```text
    /// sin theta = hypot(x, y),   versine = sin^2 theta / (1 + |z|)
    /// ```
    ///
    /// The vector must be normalized to rounding: a length of `1 + d` has the effect of an error of
    /// about `l d` in a function of degree `l`. A NaN component is not rejected, since this
    /// function is called once per point of a transform; the result is NaN.
    #[must_use]
    #[inline]
    pub fn from_direction(dir: DVec3) -> Self {
        let sin = dir.x.hypot(dir.y);
        let cos = dir.z.abs();
        Self { versine: sin * sin / (1.0 + cos), sin, cos, south: dir.z < 0.0 }
    }

    /// Returns `1 - cos theta'`, in `[0, 1]` up to rounding.
    #[must_use]
    #[inline]
    pub const fn versine(self) -> f64 {
        self.versine
    }

    /// Returns `sin theta`, in `[0, 1]` up to rounding.
    #[must_use]
    #[inline]
    pub const fn sin(self) -> f64 {
        self.sin
    }

    /// Returns `cos theta`, negative in the southern hemisphere.
    #[must_use]
    #[inline]
    pub const fn cos(self) -> f64 {
        if self.south { -self.cos } else { self.cos }
    }

    /// Returns whether `theta > pi/2`, where functions of odd `l + m` change sign.
    #[must_use]
    #[inline]
    pub const fn is_south(self) -> bool {
        self.south
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn invalid_angles_are_errors() {
        for theta in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -5e-324, PI.next_up(), 4.0] {
            let result = Colatitude::from_theta(theta);
            assert!(matches!(result, Err(Error::Colatitude { .. })), "theta = {theta}: {result:?}");
        }
        assert!(Colatitude::from_direction(DVec3::new(f64::NAN, 0.0, 1.0)).sin().is_nan());
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "exact by construction")]
    fn poles_and_equator() {
        let north = Colatitude::from_direction(DVec3::Z);
        assert_eq!(
            (north.versine(), north.sin(), north.cos(), north.is_south()),
            (0.0, 0.0, 1.0, false)
        );
        let south = Colatitude::from_direction(DVec3::NEG_Z);
        assert_eq!(
            (south.versine(), south.sin(), south.cos(), south.is_south()),
            (0.0, 0.0, -1.0, true)
        );
        let equator = Colatitude::from_direction(DVec3::X);
        assert_eq!((equator.versine(), equator.sin(), equator.cos()), (1.0, 1.0, 0.0));
        assert!(!Colatitude::from_theta(FRAC_PI_2).unwrap().is_south());
        assert!(Colatitude::from_theta(FRAC_PI_2.next_up()).unwrap().is_south());
        // Digits of sin and cos on both sides of pi/2, from pi/2 = FRAC_PI_2 + PI_TAIL/2.
        assert_eq!(Colatitude::from_theta(FRAC_PI_2).unwrap().cos(), 0.5 * PI_TAIL);
        let past = Colatitude::from_theta(FRAC_PI_2.next_up()).unwrap();
        let exact = 0.5 * PI_TAIL - f64::EPSILON;
        // The tail is subtracted from a rounded number of similar size.
        assert!((past.cos() / exact - 1.0).abs() < 2.0 * f64::EPSILON, "{past:?}");
    }

    proptest! {
        #[test]
        fn both_constructors_agree(
            theta in prop_oneof![0.0..=PI, 0.0..1e-6_f64, (PI - 1e-6)..=PI, (FRAC_PI_2 - 1e-4)..(FRAC_PI_2 + 1e-4)],
            phi in 0.0..TAU,
        ) {
            let a = Colatitude::from_theta(theta).unwrap();
            let (s, c) = (a.sin(), a.cos());
            let b = Colatitude::from_direction(DVec3::new(s * phi.cos(), s * phi.sin(), c));
            // x and y have two roundings each, hypot one; the versine doubles the error of the
            // sine.
            let relative = 8.0 * f64::EPSILON;
            prop_assert!((a.sin() - b.sin()).abs() <= relative * a.sin(), "theta = {theta:e}: {a:?} {b:?}");
            prop_assert!(
                (a.versine() - b.versine()).abs() <= relative * a.versine(),
                "theta = {theta:e}: {a:?} {b:?}"
            );
            prop_assert_eq!(a.is_south(), b.is_south());
        }
    }
}
