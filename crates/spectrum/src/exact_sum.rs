use smallvec::SmallVec;

/// Bits per digit.
const DIGIT: u32 = 32;
/// Binary exponent of the lowest bit of the lowest digit, that of the smallest subnormal f64.
const LOWEST: i32 = -1074;
/// Number of additions after which carries are propagated. An addition changes a digit by less than
/// 2^32, so an i64 does not overflow.
const MAX_PENDING: u32 = 1 << 29;

/// The digits that need no allocation: those of squares and their rounding errors for numbers of
/// similar size. There is one sum for each band of a spectrum.
const INLINE: usize = 8;

/// A sum of f64 numbers without rounding, independent of order and grouping.
///
/// The sum is a fixed-point number wide enough for every f64 (Kulisch 1971). Only the digits in use
/// are stored: numbers of similar size take about 100 bytes, without an allocation. An addition costs
/// a few nanoseconds.
///
/// # Examples
///
/// ```
/// use sphvar_spectrum::ExactSum;
/// let mut sum = ExactSum::default();
/// for x in [1e300, 1.0, -1e300, 1e-300] {
///     sum.add(x);
/// }
/// assert_eq!(sum.value(), 1.0);
/// assert_eq!(sum.value_and_rest(), (1.0, 1e-300));
/// ```
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Digits")
)]
pub struct ExactSum {
    /// `sum = sum_i digits[i] 2^(LOWEST + 32 (first + i))`.
    digits: SmallVec<[i64; INLINE]>,
    first: usize,
    pending: u32,
    /// The floating-point sum of the infinite and NaN terms; 0 if there are none.
    non_finite: f64,
}

/// Deserialized fields of an [`ExactSum`] before validation.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Digits {
    digits: Vec<i64>,
    first: usize,
    pending: u32,
    non_finite: f64,
}

/// Maximum number of digits, above that of any f64 and its carries.
#[cfg(feature = "serde")]
const MAX_DIGITS: usize = 72;

#[cfg(feature = "serde")]
impl TryFrom<Digits> for ExactSum {
    type Error = &'static str;

    fn try_from(loaded: Digits) -> Result<Self, Self::Error> {
        let Digits { digits, first, pending, non_finite } = loaded;
        let in_range = first <= MAX_DIGITS && digits.len() <= MAX_DIGITS - first;
        // The largest digit after 2^29 additions of less than 2^32.
        let small = digits.iter().all(|d| d.unsigned_abs() <= 1 << 61);
        if in_range && small && pending <= MAX_PENDING {
            Ok(Self { digits: digits.into(), first, pending, non_finite })
        } else {
            Err("invalid digits of an exact sum")
        }
    }
}

impl ExactSum {
    /// Adds a number. Infinities and NaN make the value infinite or NaN as in a floating-point sum.
    pub fn add(&mut self, x: f64) {
        if !x.is_finite() {
            self.non_finite += x;
            return;
        }
        let bits = x.to_bits();
        let biased = (bits >> 52) & 0x7ff;
        let fraction = bits & ((1 << 52) - 1);
        // Subnormals have the exponent of the smallest normal number and no hidden bit.
        let (significand, shift) =
            if biased == 0 { (fraction, 0) } else { (fraction | 1 << 52, biased - 1) };
        if significand == 0 {
            return;
        }
        #[expect(clippy::cast_possible_truncation, reason = "the shift is below 2048")]
        let (digit, offset) = (shift as usize / DIGIT as usize, shift as u32 % DIGIT);
        self.extend_to(digit, digit + 3);
        let wide = u128::from(significand) << offset;
        let at = digit - self.first;
        for (i, slot) in self.digits[at..at + 3].iter_mut().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "extracts one digit")]
            let part = i64::from((wide >> (DIGIT as usize * i)) as u32);
            *slot += if x.is_sign_negative() { -part } else { part };
        }
        self.pending += 1;
        if self.pending == MAX_PENDING {
            self.propagate();
        }
    }

    /// Adds another sum, with the same result as adding its numbers one by one.
    pub fn merge(&mut self, other: &Self) {
        self.non_finite += other.non_finite;
        let mut other = other.clone();
        other.propagate();
        self.propagate();
        if other.digits.is_empty() {
            return;
        }
        self.extend_to(other.first, other.first + other.digits.len());
        let at = other.first - self.first;
        for (slot, digit) in self.digits[at..].iter_mut().zip(&other.digits) {
            *slot += digit;
        }
        // A sum of two propagated numbers has digits as large as those after two additions.
        self.pending = 2;
    }

    /// Returns the sum as an f64, within one unit in the last place.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value_and_rest().0
    }

    /// Returns the sum as an f64, and the remainder of the exact sum as another f64: about 106 bits
    /// together.
    ///
    /// Both depend only on the exact sum. The remainder of an infinite or NaN sum is 0.
    #[must_use]
    pub fn value_and_rest(&self) -> (f64, f64) {
        if self.non_finite != 0.0 {
            return (self.non_finite, 0.0);
        }
        let mut exact = self.clone();
        let value = exact.round();
        if !value.is_finite() {
            return (value, 0.0);
        }
        exact.add(-value);
        (value, exact.round())
    }

    /// Returns the value of the digits, added from the lowest to the highest. Propagates carries.
    fn round(&mut self) -> f64 {
        self.propagate();
        // Use the magnitude, so that the digits above the leading one are zero.
        let negative = self.digits.last().is_some_and(|&d| d < 0);
        if negative {
            for d in &mut self.digits {
                *d = -*d;
            }
            self.propagate();
        }
        let mut magnitude = 0.0;
        for (i, &d) in self.digits.iter().enumerate() {
            if d != 0 {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_possible_wrap,
                    reason = "a digit index is below 70, a propagated digit below 2^32"
                )]
                let part = times_power_of_two(
                    d as f64,
                    LOWEST + (DIGIT as usize * (self.first + i)) as i32,
                );
                magnitude += part;
            }
        }
        if negative {
            for d in &mut self.digits {
                *d = -*d;
            }
            -magnitude
        } else {
            magnitude
        }
    }

    /// Extends the stored digits to cover `from..until`.
    fn extend_to(&mut self, from: usize, until: usize) {
        if self.digits.is_empty() {
            self.first = from;
        }
        if from < self.first {
            self.digits.insert_many(0, std::iter::repeat_n(0, self.first - from));
            self.first = from;
        }
        let needed = until - self.first;
        if self.digits.len() < needed {
            self.digits.resize(needed, 0);
        }
    }

    /// Normalizes every digit except the leading one to [0, 2^32); the leading one carries the
    /// sign.
    fn propagate(&mut self) {
        let mut carry = 0;
        for d in &mut self.digits {
            let total = *d + carry;
            carry = total >> DIGIT;
            *d = total - (carry << DIGIT);
        }
        if let Some(leading) = self.digits.last_mut().filter(|_| carry == -1) {
            // Keep the leading digit of a negative number negative, so that no digit is added per
            // call.
            *leading -= 1 << DIGIT;
        } else if carry != 0 {
            self.digits.push(carry);
        }
        while self.digits.last() == Some(&0) {
            self.digits.pop();
        }
        self.pending = 0;
    }
}

/// Returns `x 2^exponent` for |exponent| up to 2100, in two steps so that the power of two does not
/// overflow.
fn times_power_of_two(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * 2f64.powi(half) * 2f64.powi(exponent - half)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{ProptestConfig, any, prop, prop_assert_eq, proptest};

    use super::ExactSum;

    fn sum(numbers: &[f64]) -> ExactSum {
        let mut sum = ExactSum::default();
        for &x in numbers {
            sum.add(x);
        }
        sum
    }

    #[test]
    fn extreme_numbers_are_summed_exactly() {
        let tiny = f64::from_bits(1);
        let cases: [(&[f64], f64); 8] = [
            (&[], 0.0),
            (&[0.0, -0.0], 0.0),
            (&[tiny], tiny),
            (&[-tiny, f64::MIN_POSITIVE], f64::from_bits((1 << 52) - 1)),
            (&[f64::MAX, tiny, -f64::MAX], tiny),
            (&[f64::MAX, f64::MAX, -f64::MAX], f64::MAX),
            (&[-1.0, 2f64.powi(-53)], -1.0 + 2f64.powi(-53)),
            (&[2f64.powi(32), -1.0], 4294967295.0),
        ];
        for (numbers, expected) in cases {
            let got = sum(numbers).value();
            assert_eq!(got.to_bits(), expected.to_bits(), "{numbers:?} gave {got:e}");
        }
    }

    #[test]
    fn negative_sums_do_not_grow() {
        let mut total = ExactSum::default();
        for _ in 0..1000 {
            total.merge(&sum(&[-1.0, 2f64.powi(-60)]));
        }
        assert!(total.digits.len() <= 6, "{} digits", total.digits.len());
        assert_eq!(total.value_and_rest(), (-1000.0, 1000.0 * 2f64.powi(-60)));
    }

    #[test]
    fn infinities_and_nan_propagate() {
        assert!(sum(&[1.0, f64::INFINITY]).value() > f64::MAX);
        assert!(sum(&[f64::NEG_INFINITY, f64::INFINITY]).value().is_nan());
        assert!(sum(&[f64::NAN]).value().is_nan());
        assert!(sum(&[f64::MAX, f64::MAX]).value() > f64::MAX);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// Reference: integer arithmetic. Multiples of 2^-20 below 2^60 are exact in i128.
        #[test]
        fn the_sum_equals_an_integer_sum(numbers in prop::collection::vec(any::<i64>(), 0..40)) {
            let scaled: Vec<f64> =
                numbers.iter().map(|&k| (k >> 11) as f64 * 2f64.powi(-20)).collect();
            let exact: i128 = numbers.iter().map(|&k| i128::from(k >> 11)).sum();
            let (value, rest) = sum(&scaled).value_and_rest();
            #[expect(clippy::cast_possible_truncation, reason = "integers below 2^60")]
            let integer = |x: f64| (x * 2f64.powi(20)) as i128;
            let back = integer(value) + integer(rest);
            prop_assert_eq!(back, exact);
        }

        #[test]
        fn order_and_grouping_do_not_matter(
            bits in prop::collection::vec(any::<u64>(), 0..60),
            cut in 0usize..60,
        ) {
            let numbers: Vec<f64> =
                bits.iter().map(|&b| f64::from_bits(b)).filter(|x| x.is_finite()).collect();
            let whole = sum(&numbers).value_and_rest();
            let reversed: Vec<f64> = numbers.iter().rev().copied().collect();
            prop_assert_eq!(sum(&reversed).value_and_rest(), whole);
            let (left, right) = numbers.split_at(cut.min(numbers.len()));
            let mut merged = sum(right);
            merged.merge(&sum(left));
            prop_assert_eq!(merged.value_and_rest(), whole);
        }
    }
}
