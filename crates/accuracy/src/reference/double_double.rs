use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use super::power;

/// A number of about 32 digits: an unevaluated sum of two `f64` with a separate exponent.
///
/// ```text
/// (hi + lo) 2^exponent,   1 <= |hi| < 2,   |lo| <= ulp(hi)/2,   or all fields 0
/// ```
///
/// The relative error of a sum, difference, product, quotient or root is at most 16 `UNIT^2` of the
/// exact result, with `UNIT = EPSILON/2 = 2^-53`, so at most `2e-31`. The exponent has 64 bits, so
/// no computation on the sphere underflows. NaN and infinities propagate as NaN or infinities.
///
/// # Examples
///
/// ```
/// use sphvar_accuracy::reference::DoubleDouble;
///
/// let third = DoubleDouble::ONE / DoubleDouble::from(3.0);
/// let rest = third * DoubleDouble::from(3.0) - DoubleDouble::ONE;
/// assert!(rest.value().abs() < 1e-31);
/// ```
///
/// # References
///
/// Joldes, Muller and Popescu 2017, "Tight and rigorous error bounds for basic building blocks of
/// double-word arithmetic", doi:10.1145/3121432, algorithms 6 (sum) and 11 (product).
#[derive(Clone, Copy, Debug)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
    exponent: i64,
}

/// Bits of the fraction field of an `f64`.
const FRACTION_BITS: u32 = 52;
/// The exponent field of 1.0.
const BIAS: i64 = 1023;
/// The exponent field as a mask, before shifting.
const EXPONENT_MASK: u64 = 0x7ff;
/// The difference of exponents beyond which the smaller summand is below the last digit of the
/// larger one.
const NEGLIGIBLE: i64 = 220;

impl DoubleDouble {
    /// The number zero.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0, exponent: 0 };
    /// The number one.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0, exponent: 0 };

    /// Returns the exact value of `mantissa * 2^exponent`.
    #[must_use]
    pub fn scaled(mantissa: f64, exponent: i64) -> Self {
        Self::normal(mantissa, 0.0, exponent)
    }

    /// Returns the exact value of `hi + lo` times a power of two; `|lo|` must not be above `|hi|`.
    pub(crate) fn normal(hi: f64, lo: f64, exponent: i64) -> Self {
        let sum = hi + lo;
        let rest = lo - (sum - hi);
        let field = exponent_field(sum);
        if field == 0 {
            if sum == 0.0 {
                return Self::ZERO;
            }
            // Subnormal: multiplication by 2^54 makes it normal exactly; the other part is 0.
            return Self::normal(sum * power_of_two(54), 0.0, exponent.saturating_sub(54));
        }
        if field == EXPONENT_MASK.cast_signed() {
            return Self { hi: sum, lo: 0.0, exponent: 0 };
        }
        let shift = field - BIAS;
        // Two factors, because the power itself may be out of range.
        let (half, other) = (power_of_two(-(shift / 2)), power_of_two(shift / 2 - shift));
        Self {
            hi: sum * half * other,
            lo: rest * half * other,
            exponent: exponent.saturating_add(shift),
        }
    }

    /// Returns the nearest `f64`; 0 below its range, infinity above it.
    #[must_use]
    pub fn value(self) -> f64 {
        match self.exponent {
            1024.. => self.hi * f64::INFINITY,
            -1022..1024 => self.hi * power_of_two(self.exponent),
            // The first product is exact, so the number is rounded once.
            -1080..-1022 => self.hi * power_of_two(self.exponent + 100) * power_of_two(-100),
            _ => self.hi * 0.0,
        }
    }

    /// Returns the leading digits, a mantissa in `[1, 2)` up to its sign or 0, and their power of
    /// two.
    #[must_use]
    pub const fn leading(self) -> (f64, i64) {
        (self.hi, self.exponent)
    }

    /// Returns the number times `2^exponent`, exactly.
    #[must_use]
    pub fn shifted(self, exponent: i64) -> Self {
        if self.hi == 0.0 {
            self
        } else {
            Self { exponent: self.exponent.saturating_add(exponent), ..self }
        }
    }

    /// Returns the magnitude.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Returns the value of a decimal such as `-1.25e-3000`, of at most 30 digits; `None` for
    /// anything else.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (digits, power) = match text.split_once('e') {
            Some((digits, power)) => (digits, power.parse::<i64>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        // A second point, or a sign in the fraction, is invalid.
        if !fraction.bytes().all(|b| b.is_ascii_digit()) {
            return None;
        }
        let integer: i128 = [whole, fraction].concat().parse().ok()?;
        if integer.unsigned_abs() >= 10_u128.pow(30) {
            return None;
        }
        let power = power.checked_sub(i64::try_from(fraction.len()).ok()?)?;
        let ten = Self::from(10.0).power(power.unsigned_abs());
        let integer = Self::of_integer(integer);
        Some(if power < 0 { integer / ten } else { integer * ten })
    }

    /// Exact up to 106 bits.
    #[expect(clippy::cast_possible_truncation, reason = "the rounded integer is below 10^31")]
    fn of_integer(integer: i128) -> Self {
        let hi = integer as f64;
        Self::normal(hi, (integer - hi as i128) as f64, 0)
    }

    /// Returns the `n`-th power; `0^0 = 1`.
    ///
    /// Relative error `16 n UNIT^2` over `n` times that of `self`. Cost `O(log n)`.
    #[must_use]
    pub fn power(self, n: u64) -> Self {
        power(Self::ONE, self, n)
    }

    /// Returns the square root, NaN of a negative number: the `f64` root with one correction of
    /// Newton.
    #[must_use]
    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return self;
        }
        let odd = self.exponent.rem_euclid(2);
        let radicand = if odd == 1 { 2.0 * self.hi } else { self.hi };
        let root = Self::normal(radicand.sqrt(), 0.0, (self.exponent - odd) / 2);
        let rest = self - root * root;
        root + Self::normal(rest.hi / (2.0 * root.hi), 0.0, rest.exponent - root.exponent)
    }
}

/// Returns the rounded sum and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Returns the biased exponent field of `x`.
const fn exponent_field(x: f64) -> i64 {
    ((x.to_bits() >> FRACTION_BITS) & EXPONENT_MASK).cast_signed()
}

/// Returns `2^exponent` for `-1022 <= exponent <= 1023`.
const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((exponent + BIAS).cast_unsigned() & EXPONENT_MASK) << FRACTION_BITS)
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self::scaled(x, 0)
    }
}

impl From<u64> for DoubleDouble {
    fn from(n: u64) -> Self {
        Self::of_integer(i128::from(n))
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo, exponent: self.exponent }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (large, small) =
            if self.hi == 0.0 || (other.hi != 0.0 && other.exponent > self.exponent) {
                (other, self)
            } else {
                (self, other)
            };
        let gap = large.exponent - small.exponent;
        let finite = large.hi.is_finite() && small.hi.is_finite();
        if small.hi == 0.0 || (gap > NEGLIGIBLE && finite) {
            return large;
        }
        let scale = power_of_two(-gap.clamp(0, NEGLIGIBLE));
        let (high, high_rest) = two_sum(large.hi, small.hi * scale);
        let (low, low_rest) = two_sum(large.lo, small.lo * scale);
        let middle = high_rest + low;
        let sum = high + middle;
        let rest = middle - (sum - high) + low_rest;
        Self::normal(sum, rest, large.exponent)
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.hi * other.hi;
        let rounding = self.hi.mul_add(other.hi, -product);
        let cross = self.hi * other.lo + self.lo * other.hi;
        Self::normal(product, rounding + cross, self.exponent.saturating_add(other.exponent))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    /// Computes the `f64` quotient with one Newton correction.
    fn div(self, other: Self) -> Self {
        let exponent = self.exponent.saturating_sub(other.exponent);
        let quotient = Self::normal(self.hi / other.hi, 0.0, exponent);
        let rest = self - quotient * other;
        quotient + Self::normal(rest.hi / other.hi, 0.0, rest.exponent - other.exponent)
    }
}

impl PartialEq for DoubleDouble {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        (*self - *other).hi.partial_cmp(&0.0)
    }
}
