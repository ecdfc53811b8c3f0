//! Double-double arithmetic.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum `hi + lo`, `|lo|` at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Double {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

impl Double {
    pub(crate) const ONE: Self = Self { hi: 1.0, lo: 0.0 };
    /// pi; the second part is the remainder of the `f64` nearest to pi.
    pub(crate) const PI: Self = Self { hi: std::f64::consts::PI, lo: 1.224646799147353177e-16 };

    /// Returns `a + b` without error (Knuth's two-sum).
    #[inline(always)]
    pub(crate) fn sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let part = hi - a;
        Self { hi, lo: (a - (hi - part)) + (b - part) }
    }

    /// Returns `a + b` without error if `|b|` does not exceed `|a|`.
    #[inline(always)]
    fn ordered_sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        Self { hi, lo: b - (hi - a) }
    }

    /// Returns `a b` without error, unless a part underflows.
    #[inline(always)]
    pub(crate) fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        Self { hi, lo: a.mul_add(b, -hi) }
    }

    /// Returns the product with a power of two.
    #[inline(always)]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { hi: self.hi * factor, lo: self.lo * factor }
    }

    /// Returns the square root, by a Newton correction of that of `hi`.
    pub(crate) fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return self;
        }
        let root = self.hi.sqrt();
        let rest = self - Self::product(root, root);
        Self::ordered_sum(root, rest.hi / (2.0 * root))
    }
}

impl From<f64> for Double {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self { hi: x, lo: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (sum, tails) = (Self::sum(self.hi, other.hi), Self::sum(self.lo, other.lo));
        let sum = Self::ordered_sum(sum.hi, sum.lo + tails.hi);
        Self::ordered_sum(sum.hi, sum.lo + tails.lo)
    }
}

impl Neg for Double {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Double {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.hi, other.hi);
        let cross = self.hi * other.lo + self.lo * other.hi;
        Self::ordered_sum(product.hi, product.lo + cross)
    }
}

impl Div for Double {
    type Output = Self;

    /// Divides, by two corrections of the quotient of the leading parts.
    fn div(self, by: Self) -> Self {
        let first = self.hi / by.hi;
        let rest = self - by * Self::from(first);
        let second = rest.hi / by.hi;
        let rest = rest - by * Self::from(second);
        Self::ordered_sum(first, second) + Self::from(rest.hi / by.hi)
    }
}

#[test]
fn it_has_thirty_digits() {
    let third = Double::ONE / Double::from(3.0);
    let root = Double::from(7.0).sqrt();
    for (name, zero) in [
        ("quotient", third + third + third - Double::ONE),
        ("root", root * root / Double::from(7.0) - Double::ONE),
        ("quotients of pi", Double::PI / Double::PI - Double::ONE),
        ("cancelling sum", (third + Double::from(1e16)) - Double::from(1e16) - third),
    ] {
        // A few units of 2^-105; the term 1e16 costs 16 digits.
        let tolerance = if name == "cancelling sum" { 1e-15 } else { 1e-31 };
        assert!(zero.hi.abs() <= tolerance, "{name}: {zero:?}");
    }
}
