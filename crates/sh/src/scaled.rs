use core::ops::{Mul, Neg};

/// A real number `mantissa * 2^exponent` with an exponent beyond the range of `f64`.
///
/// Sectoral functions reach `sin(1e-300)^20000`, about `2^-2e7`; a recurrence that starts there
/// needs the digits of a number far below the smallest `f64`. Every function of this crate returns
/// the normal form: `1 <= |mantissa| < 2`, or mantissa 0 with exponent 0. A NaN or infinite
/// mantissa is unchanged.
///
/// # Examples
///
/// ```
/// use sphvar_sh::Scaled;
///
/// let x = Scaled::new(1e-300, 0).power(1000);
/// assert_eq!(x.value(), 0.0);
/// assert!((x.log10_abs() + 300_000.0).abs() < 1e-9);
/// assert_eq!(Scaled::new(3.0, -1), Scaled { mantissa: 1.5, exponent: 0 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaled {
    /// The mantissa, `1 <= |mantissa| < 2` or 0 in normal form.
    pub mantissa: f64,
    /// The power of two.
    pub exponent: i64,
}

/// Number of bits of the fraction field of an `f64`.
const FRACTION_BITS: u32 = 52;
/// The exponent field of 1.0.
const BIAS: i64 = 1023;
/// The exponent field as a mask, before shifting.
const EXPONENT_MASK: u64 = 0x7ff;

impl Scaled {
    /// The number zero.
    pub const ZERO: Self = Self { mantissa: 0.0, exponent: 0 };
    /// The number one.
    pub const ONE: Self = Self { mantissa: 1.0, exponent: 0 };

    /// Returns `mantissa * 2^exponent` in normal form.
    #[must_use]
    #[inline]
    pub fn new(mantissa: f64, exponent: i64) -> Self {
        let field = exponent_field(mantissa);
        if field == 0 {
            if mantissa == 0.0 {
                return Self::ZERO;
            }
            // Subnormal: multiplication by 2^54 normalizes it exactly.
            return Self::new(mantissa * power_of_two(54), exponent.saturating_sub(54));
        }
        if field == EXPONENT_MASK.cast_signed() {
            return Self { mantissa, exponent: 0 };
        }
        let cleared = mantissa.to_bits() & !(EXPONENT_MASK << FRACTION_BITS);
        let unit = f64::from_bits(cleared | 1.0_f64.to_bits());
        Self { mantissa: unit, exponent: exponent.saturating_add(field - BIAS) }
    }

    /// Returns the nearest `f64`: 0 below the range of `f64`, infinite above it.
    ///
    /// The result is correctly rounded, also in the subnormal range.
    #[must_use]
    #[inline]
    pub fn value(self) -> f64 {
        let Self { mantissa, exponent } = Self::new(self.mantissa, self.exponent);
        match exponent {
            1024.. => mantissa * f64::INFINITY,
            -1022..1024 => mantissa * power_of_two(exponent),
            // The first product is exact, so the number is rounded only once.
            -1080..-1022 => mantissa * power_of_two(exponent + 100) * power_of_two(-100),
            _ => 0.0,
        }
    }

    /// Returns the `n`-th power; `0^0 = 1`.
    ///
    /// Adds a relative error of at most `(n - 1) EPSILON / 2` to that of `self`, to first order:
    /// squaring only shares factors of the plain product of `n` terms. The cost is `O(log n)`.
    #[must_use]
    pub fn power(self, n: usize) -> Self {
        let (mut result, mut square, mut rest) = (Self::ONE, self, n);
        while rest > 0 {
            if rest % 2 == 1 {
                result = result * square;
            }
            rest /= 2;
            if rest > 0 {
                square = square * square;
            }
        }
        result
    }

    /// Returns the decimal logarithm of the absolute value; `-inf` for zero.
    #[must_use]
    pub fn log10_abs(self) -> f64 {
        self.mantissa.abs().log10() + self.exponent as f64 * core::f64::consts::LOG10_2
    }
}

impl Mul for Scaled {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        // Mantissas below 2 cannot overflow; in normal form they cannot underflow either.
        Self::new(self.mantissa * other.mantissa, self.exponent.saturating_add(other.exponent))
    }
}

impl Mul<f64> for Scaled {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        self * Self::new(factor, 0)
    }
}

impl Neg for Scaled {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { mantissa: -self.mantissa, exponent: self.exponent }
    }
}

/// Returns the biased exponent field of `x`.
#[inline]
const fn exponent_field(x: f64) -> i64 {
    ((x.to_bits() >> FRACTION_BITS) & EXPONENT_MASK).cast_signed()
}

/// Returns `2^exponent` for `-1022 <= exponent <= 1023`.
#[inline]
const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((exponent + BIAS).cast_unsigned() & EXPONENT_MASK) << FRACTION_BITS)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "the operations under test are exact or correctly rounded")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn extremes() {
        for x in [5e-324, -5e-324, f64::MIN_POSITIVE, f64::MAX, 1.0, -0.75, 0.0, 2.5e-310] {
            let scaled = Scaled::new(x, 0);
            assert_eq!(scaled.value(), x, "x = {x:e}");
            assert!(
                x == 0.0 || (1.0..2.0).contains(&scaled.mantissa.abs()),
                "x = {x:e}: {scaled:?}"
            );
        }
        assert!(Scaled::new(f64::NAN, 7).value().is_nan());
        assert_eq!(Scaled::new(f64::NEG_INFINITY, -5000).value(), f64::NEG_INFINITY);
        assert_eq!(Scaled::new(-1.5, 1024).value(), f64::NEG_INFINITY);
        assert_eq!(Scaled::new(1.5, i64::MAX).value(), f64::INFINITY);
        assert_eq!(Scaled::new(1.5, i64::MIN).value(), 0.0);
        assert_eq!(Scaled::new(5e-324, i64::MIN).value(), 0.0);
        assert_eq!(Scaled::new(5e-324, 0).power(usize::MAX).value(), 0.0);
        assert_eq!(Scaled::ZERO.power(0), Scaled::ONE);
    }

    #[test]
    fn values_below_the_normal_range_are_rounded_once() {
        // 1.5 * 2^-1074 is halfway between 2^-1074 and 2^-1073: ties to even gives the latter.
        assert_eq!(Scaled::new(1.5, -1074).value(), 1e-323);
        // 2^-1075 is a tie with 0; larger numbers are not.
        assert_eq!(Scaled::new(1.0, -1075).value(), 0.0);
        assert_eq!(Scaled::new(1.0 + f64::EPSILON, -1075).value(), 5e-324);
    }

    proptest! {
        #[test]
        fn products_agree_with_plain_arithmetic(a in -1e100..1e100_f64, b in -1e100..1e100_f64) {
            prop_assert_eq!((Scaled::new(a, 0) * Scaled::new(b, 0)).value(), a * b);
            prop_assert_eq!((Scaled::new(a, 0) * b).value(), a * b);
            prop_assert_eq!((-Scaled::new(a, 0)).value(), -a);
        }

        #[test]
        fn powers_agree_with_repeated_products(x in 0.5..1.5_f64, n in 0..200_usize) {
            let slow = (0..n).fold(1.0, |p, _| p * x);
            let fast = Scaled::new(x, 0).power(n).value();
            // Both are within (n - 1) EPSILON / 2.
            let bound = n as f64 * f64::EPSILON * slow;
            prop_assert!((fast - slow).abs() <= bound, "x = {x}, n = {n}: {fast} against {slow}");
        }
    }
}
