//! Numbers of about 32 digits as unevaluated sums of two `f64`, with an exponent of their own.

use core::ops::{Add, Mul, Neg, Sub};

use sphvar_sh::Scaled;

/// `(hi + lo) 2^exponent`, `1 <= |hi| < 2` or everything 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DoubleDouble {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
    pub(crate) exponent: i64,
}

impl DoubleDouble {
    pub(crate) const ZERO: Self = Self { hi: 0.0, lo: 0.0, exponent: 0 };

    /// The exact value of `hi + lo`, `|lo|` not above `|hi|`, times a power of two.
    fn new(hi: f64, lo: f64, exponent: i64) -> Self {
        let sum = hi + lo;
        let rest = lo - (sum - hi);
        let unit = Scaled::new(sum, 0);
        let rest = Scaled::new(rest, -unit.exponent).value();
        if sum == 0.0 {
            Self::ZERO
        } else {
            Self { hi: unit.mantissa, lo: rest, exponent: exponent + unit.exponent }
        }
    }

    /// Reads a decimal such as `-1.25e-3000`; at most 30 digits.
    pub(crate) fn parse(text: &str) -> Self {
        let (digits, power) = text
            .split_once('e')
            .map_or((text, 0), |(digits, power)| (digits, power.parse().unwrap()));
        let fraction = digits
            .split_once('.')
            .map_or(0, |(_, fraction)| i64::try_from(fraction.len()).unwrap());
        let integer: i128 = digits.replace('.', "").parse().unwrap();
        let hi = integer as f64;
        #[expect(clippy::cast_possible_truncation, reason = "the rounded integer is below 10^31")]
        let lo = (integer - hi as i128) as f64;
        let power: i64 = power - fraction;
        let ten = Self::from(10.0).power(power.unsigned_abs());
        let integer = Self::new(hi, lo, 0);
        if power < 0 { integer.over(ten) } else { integer * ten }
    }

    pub(crate) fn power(self, n: u64) -> Self {
        let (mut result, mut square, mut rest) = (Self::from(1.0), self, n);
        while rest > 0 {
            if rest % 2 == 1 {
                result = result * square;
            }
            square = square * square;
            rest /= 2;
        }
        result
    }

    /// `self / other`, by Newton's correction of the `f64` quotient.
    pub(crate) fn over(self, other: Self) -> Self {
        let quotient = Self::new(self.hi / other.hi, 0.0, self.exponent - other.exponent);
        let rest = self - quotient * other;
        quotient + Self::new(rest.hi / other.hi, 0.0, rest.exponent - other.exponent)
    }

    /// The square root, by Newton's correction of the `f64` root.
    pub(crate) fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return self;
        }
        let odd = self.exponent.rem_euclid(2);
        let radicand = Scaled::new(self.hi, odd).value();
        let root = Self::new(radicand.sqrt(), 0.0, (self.exponent - odd) / 2);
        let rest = self - root * root;
        root + Self::new(rest.hi / (2.0 * root.hi), 0.0, rest.exponent - root.exponent)
    }

    /// Sine and cosine of an `f64`, by the Taylor series of a 64th and six doublings.
    pub(crate) fn sin_cos(theta: f64) -> (Self, Self) {
        const DOUBLINGS: i64 = 6;
        let t = Self::new(theta, 0.0, -DOUBLINGS);
        let (mut sin, mut cosm1) = (Self::ZERO, Self::ZERO);
        let mut term = Self::from(1.0);
        for k in 1..=24_u32 {
            term = (term * t).over(Self::from(f64::from(k)));
            let signed = if k % 4 >= 2 { -term } else { term };
            if k % 2 == 1 {
                sin = sin + signed;
            } else {
                cosm1 = cosm1 + signed;
            }
        }
        // cos - 1 is doubled instead of cos, which would lose digits at each step.
        for _ in 0..DOUBLINGS {
            let cos = cosm1 + Self::from(1.0);
            (sin, cosm1) = (Self::from(2.0) * sin * cos, -(Self::from(2.0) * sin * sin));
        }
        (sin, cosm1 + Self::from(1.0))
    }

    /// The nearest number in the crate's own form.
    pub(crate) fn scaled(self) -> Scaled {
        Scaled::new(self.hi, self.exponent)
    }

    /// `(other - self) / scale`, rounded to an `f64`.
    pub(crate) fn excess_of(self, other: Scaled, scale: Scaled) -> f64 {
        let difference = Self::new(other.mantissa, 0.0, other.exponent) - self;
        Scaled::new(difference.hi / scale.mantissa, difference.exponent - scale.exponent).value()
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self::new(x, 0.0, 0)
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
        if self.hi == 0.0 || other.hi == 0.0 {
            return if self.hi == 0.0 { other } else { self };
        }
        let exponent = self.exponent.max(other.exponent);
        let at = |x: f64, own: i64| Scaled::new(x, own - exponent).value();
        let (a, b) = (at(self.hi, self.exponent), at(other.hi, other.exponent));
        let sum = a + b;
        let part = sum - a;
        let rounding = (a - (sum - part)) + (b - part);
        let tail = at(self.lo, self.exponent) + at(other.lo, other.exponent);
        Self::new(sum, rounding + tail, exponent)
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
        Self::new(product, rounding + cross, self.exponent + other.exponent)
    }
}
