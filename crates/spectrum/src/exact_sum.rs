/// Bits per digit.
const DIGIT: u32 = 32;
/// Binary exponent of the lowest bit of the lowest digit, that of the smallest subnormal f64.
const LOWEST: i32 = -1074;
/// Number of digits of any sum: 66 for the largest f64, and those of carries.
const ALL: usize = 72;
/// Digits that need no allocation: those of numbers whose sizes differ by up to 2^120 or more, such as
/// squares and their rounding errors. There are two sums for each band of a spectrum.
const FEW: usize = 8;
/// Digits of the window below the first number that is added.
const BELOW: usize = 4;
/// Number of additions after which carries are propagated. An addition changes a digit by less than
/// 2^32, so an i64 does not overflow.
const MAX_PENDING: u32 = 1 << 29;

/// A sum of f64 numbers without rounding, independent of order and grouping.
///
/// The sum is a fixed-point number wide enough for every f64 (Kulisch 1971). Numbers of similar size
/// take about 90 bytes, without an allocation; those of very different sizes 0.6 kB. An addition costs
/// two nanoseconds.
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
    serde(into = "Fields", try_from = "Fields")
)]
pub struct ExactSum {
    digits: Digits,
    /// At least the number of additions since the last propagation of carries, which counts as one; 0
    /// if there is no number, in which case all digits are 0.
    pending: u32,
    /// The floating-point sum of the infinite and NaN terms; 0 if there are none.
    non_finite: f64,
}

/// The digits of a sum, `sum_i digit[i] 2^(LOWEST + 32 i)`, most of which are 0.
#[derive(Clone, Debug)]
enum Digits {
    /// Those from `first` on; all others are 0.
    Few {
        first: usize,
        digits: [i64; FEW],
    },
    All(Box<[i64; ALL]>),
}

impl Default for Digits {
    fn default() -> Self {
        Self::Few { first: 0, digits: [0; FEW] }
    }
}

impl Digits {
    /// Returns the number of the first stored digit and the stored digits.
    fn stored(&self) -> (usize, &[i64]) {
        match self {
            Self::Few { first, digits } => (*first, digits),
            Self::All(digits) => (0, &**digits),
        }
    }

    fn stored_mut(&mut self) -> &mut [i64] {
        match self {
            Self::Few { digits, .. } => digits,
            Self::All(digits) => &mut **digits,
        }
    }

    /// Returns the numbers of the digits other than 0: from the first to one past the last.
    fn in_use(&self) -> Option<(usize, usize)> {
        let (first, digits) = self.stored();
        let lowest = digits.iter().position(|&d| d != 0)?;
        let highest = digits.iter().rposition(|&d| d != 0)?;
        Some((first + lowest, first + highest + 1))
    }

    /// Stores the digits `from..until`, at most [`ALL`], as well as those in use.
    fn cover(&mut self, from: usize, until: usize) {
        let Self::Few { first, digits } = *self else { return };
        if from >= first && until <= first + FEW {
            return;
        }
        let (lowest, highest) = self
            .in_use()
            .map_or((from, until), |(lowest, highest)| (lowest.min(from), highest.max(until)));
        let copy = |out: &mut [i64], start: usize| {
            for (i, &d) in digits.iter().enumerate().filter(|(_, d)| **d != 0) {
                out[first + i - start] = d;
            }
        };
        if highest - lowest <= FEW {
            let spare = FEW - (highest - lowest);
            let start = lowest.saturating_sub(spare / 2).min(ALL - FEW);
            let mut few = [0; FEW];
            copy(&mut few, start);
            *self = Self::Few { first: start, digits: few };
        } else {
            let mut all = Box::new([0; ALL]);
            copy(&mut *all, 0);
            *self = Self::All(all);
        }
    }

    /// Normalizes every digit except the last stored one to [0, 2^32); that one carries the sign, and
    /// is smaller than 2^32 in magnitude.
    fn propagate(&mut self) {
        let carried = carry(self.stored_mut());
        if carried.unsigned_abs() < 1 << DIGIT {
            return;
        }
        if let Self::Few { first, .. } = self {
            let above = *first + FEW + 1;
            self.cover(above - 1, above.min(ALL));
            // The digits may have moved, and there are more of them.
            carry(self.stored_mut());
        }
    }
}

/// Moves all but the lowest 32 bits of each digit to the next one. Returns the last digit.
fn carry(digits: &mut [i64]) -> i64 {
    let mut carry = 0;
    let Some((last, others)) = digits.split_last_mut() else { return 0 };
    for d in others {
        let total = *d + carry;
        carry = total >> DIGIT;
        *d = total - (carry << DIGIT);
    }
    *last += carry;
    *last
}

/// The serialized fields of an [`ExactSum`]. They depend only on the sum and on whether there are
/// numbers.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Fields {
    digits: Vec<i64>,
    first: usize,
    pending: u32,
    non_finite: f64,
}

#[cfg(feature = "serde")]
impl From<ExactSum> for Fields {
    fn from(mut sum: ExactSum) -> Self {
        sum.propagate();
        let (first, digits) = sum.digits.stored();
        let mut digits = digits.to_vec();
        // A negative leading digit instead of digits 2^32 - 1 below a digit -1.
        while let [.., below, -1] = &mut *digits {
            *below -= 1 << DIGIT;
            digits.pop();
        }
        while digits.last() == Some(&0) {
            digits.pop();
        }
        let zeros = digits.iter().take_while(|d| **d == 0).count();
        let first = if digits.is_empty() { 0 } else { first + zeros };
        digits.drain(..zeros);
        Self { digits, first, pending: sum.pending, non_finite: sum.non_finite }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Fields> for ExactSum {
    type Error = &'static str;

    fn try_from(loaded: Fields) -> Result<Self, Self::Error> {
        let Fields { digits, first, pending, non_finite } = loaded;
        let in_range = first <= ALL && digits.len() <= ALL - first;
        // The largest digit after 2^29 additions of less than 2^32. No sum of numbers has a last digit.
        let small = digits.iter().all(|d| d.unsigned_abs() <= 1 << 61);
        if !in_range || !small || first + digits.len() == ALL || pending > MAX_PENDING {
            return Err("invalid digits of an exact sum");
        }
        let mut sum = Self { non_finite, ..Self::default() };
        sum.add_digits(first, &digits);
        let largest = digits.iter().map(|d| d.unsigned_abs() >> DIGIT).max().unwrap_or(0);
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^29")]
        sum.count(pending.max(largest as u32 + 1));
        Ok(sum)
    }
}

impl ExactSum {
    /// Adds a number. Infinities and NaN make the value infinite or NaN as in a floating-point sum.
    pub fn add(&mut self, x: f64) {
        let bits = x.to_bits();
        let biased = (bits >> 52) & 0x7ff;
        let fraction = bits & ((1 << 52) - 1);
        if biased == 0x7ff {
            self.non_finite += x;
            return;
        }
        // Subnormals have the exponent of the smallest normal number and no hidden bit.
        let (significand, shift) =
            if biased == 0 { (fraction, 0) } else { (fraction | 1 << 52, biased - 1) };
        if significand == 0 {
            return;
        }
        #[expect(clippy::cast_possible_truncation, reason = "the shift is below 2048")]
        let (digit, offset) = (shift as usize / DIGIT as usize, shift as u32 % DIGIT);
        let wide = u128::from(significand) << offset;
        #[expect(clippy::cast_possible_truncation, reason = "extracts one digit")]
        let part = |i: u32| i64::from((wide >> (DIGIT * i)) as u32);
        let sign = if x.is_sign_negative() { -1 } else { 1 };
        let parts = [0, 1, 2].map(|i| sign * part(i));
        if self.pending == 0 {
            let first = digit.saturating_sub(BELOW).min(ALL - FEW);
            self.digits = Digits::Few { first, digits: [0; FEW] };
        }
        self.add_digits(digit, &parts);
        self.count(1);
    }

    /// Adds digits from a number on.
    fn add_digits(&mut self, from: usize, digits: &[i64]) {
        self.digits.cover(from, from + digits.len());
        let at = from - self.digits.stored().0;
        for (mine, digit) in self.digits.stored_mut()[at..].iter_mut().zip(digits) {
            *mine += digit;
        }
    }

    /// Counts additions, and propagates carries before the next one could overflow.
    fn count(&mut self, additions: u32) {
        self.pending += additions;
        if self.pending >= MAX_PENDING {
            self.propagate();
        }
    }

    /// Adds another sum, with the same result as adding its numbers one by one.
    pub fn merge(&mut self, other: &Self) {
        self.non_finite += other.non_finite;
        if self.pending == 0 {
            (self.digits, self.pending) = (other.digits.clone(), other.pending);
            return;
        }
        // Two sums with half of the additions at most do not overflow.
        let is_full = |sum: &Self| sum.pending > MAX_PENDING / 2;
        if is_full(self) {
            self.propagate();
        }
        let propagated;
        let mut other = other;
        if is_full(other) {
            let mut copy = other.clone();
            copy.propagate();
            propagated = copy;
            other = &propagated;
        }
        match (&mut self.digits, &other.digits) {
            (Digits::Few { first, digits }, Digits::Few { first: theirs, digits: more })
                if first == theirs =>
            {
                for (mine, digit) in digits.iter_mut().zip(more) {
                    *mine += digit;
                }
            }
            _ => {
                if let Some((from, until)) = other.digits.in_use() {
                    let (first, digits) = other.digits.stored();
                    self.add_digits(from, &digits[from - first..until - first]);
                }
            }
        }
        self.count(other.pending);
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
        let negative = self.digits.stored().1.last().is_some_and(|&d| d < 0);
        if negative {
            self.negate();
        }
        let (first, digits) = self.digits.stored();
        let mut magnitude = 0.0;
        for (i, &d) in digits.iter().enumerate() {
            if d != 0 {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_possible_wrap,
                    reason = "a digit index is below 72, a propagated digit below 2^32"
                )]
                let part =
                    times_power_of_two(d as f64, LOWEST + (DIGIT as usize * (first + i)) as i32);
                magnitude += part;
            }
        }
        if negative {
            self.negate();
            -magnitude
        } else {
            magnitude
        }
    }

    fn negate(&mut self) {
        for d in self.digits.stored_mut() {
            *d = -*d;
        }
        self.propagate();
    }

    fn propagate(&mut self) {
        self.digits.propagate();
        self.pending = self.pending.min(1);
    }
}

/// Returns `x 2^exponent` for |exponent| up to 2044, in two steps so that the power of two does not
/// overflow.
fn times_power_of_two(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * power_of_two(half) * power_of_two(exponent - half)
}

/// Returns 2^exponent for exponents from -1022 to 1023.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(u64::from((1023 + exponent).unsigned_abs()) << 52)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{ProptestConfig, any, prop, prop_assert_eq, proptest};

    use super::{ALL, Digits, ExactSum};

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
        assert!(matches!(total.digits, Digits::Few { .. }), "{total:?}");
        assert_eq!(total.value_and_rest(), (-1000.0, 1000.0 * 2f64.powi(-60)));
    }

    #[test]
    fn carries_beyond_the_stored_digits_are_kept() {
        for sign in [1.0, -1.0] {
            let mut total = sum(&[sign, sign * 2f64.powi(-70)]);
            for doublings in 1..=900 {
                total.merge(&total.clone());
                let power = sign * 2f64.powi(doublings);
                assert_eq!(total.value_and_rest(), (power, power * 2f64.powi(-70)), "{doublings}");
            }
        }
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

        /// Reference: all digits are stored from the start.
        #[test]
        fn stored_digits_do_not_matter(
            numbers in prop::collection::vec((any::<i32>(), -400i32..400), 0..40),
            range in 1i32..400,
        ) {
            let number = |&(k, e): &(i32, i32)| f64::from(k) * 2f64.powi(e % range);
            let numbers: Vec<f64> = numbers.iter().map(number).collect();
            let mut all = ExactSum { digits: Digits::All(Box::new([0; ALL])), pending: 1, non_finite: 0.0 };
            numbers.iter().for_each(|&x| all.add(x));
            prop_assert_eq!(sum(&numbers).value_and_rest(), all.value_and_rest());
            let mut merged = ExactSum::default();
            numbers.iter().for_each(|&x| merged.merge(&sum(&[x])));
            prop_assert_eq!(merged.value_and_rest(), all.value_and_rest());
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
