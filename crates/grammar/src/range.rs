use std::fmt;

/// An interval of finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    low: f64,
    high: f64,
    has_low: bool,
    has_high: bool,
}

impl Range {
    /// Every finite number.
    pub const FINITE: Self = Self::open(f64::NEG_INFINITY, f64::INFINITY);
    /// The finite numbers above 0.
    pub const POSITIVE: Self = Self::open(0.0, f64::INFINITY);
    /// The finite numbers from 0.
    pub const AT_LEAST_0: Self = Self::right_open(0.0, f64::INFINITY);

    /// Returns the range from `low` to `high`, both included.
    #[must_use]
    pub const fn closed(low: f64, high: f64) -> Self {
        Self { low, high, has_low: true, has_high: true }
    }

    /// Returns the range between `low` and `high`, both excluded.
    #[must_use]
    pub const fn open(low: f64, high: f64) -> Self {
        Self { low, high, has_low: false, has_high: false }
    }

    /// Returns the range from `low`, included, to `high`, excluded.
    #[must_use]
    pub const fn right_open(low: f64, high: f64) -> Self {
        Self { low, high, has_low: true, has_high: false }
    }

    /// Returns the range from `low`, excluded, to `high`, included.
    #[must_use]
    pub const fn left_open(low: f64, high: f64) -> Self {
        Self { low, high, has_low: false, has_high: true }
    }

    /// Returns the lower end.
    #[must_use]
    pub const fn low(&self) -> f64 {
        self.low
    }

    /// Returns the upper end.
    #[must_use]
    pub const fn high(&self) -> f64 {
        self.high
    }

    /// Returns whether `value` is in the range; NaN and infinities never are.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let above = value > self.low || (self.has_low && value >= self.low);
        let below = value < self.high || (self.has_high && value <= self.high);
        value.is_finite() && above && below
    }
}

/// Writes the range in words, to continue "must be".
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { low, high, has_low, has_high } = *self;
        match (low.is_finite(), high.is_finite()) {
            (false, false) => f.write_str("a finite number"),
            (true, false) if has_low => write!(f, "finite and at least {low}"),
            (true, false) => write!(f, "finite and above {low}"),
            (false, true) if has_high => write!(f, "finite and at most {high}"),
            (false, true) => write!(f, "finite and below {high}"),
            (true, true) => {
                let (open, close) =
                    (if has_low { '[' } else { '(' }, if has_high { ']' } else { ')' });
                write!(f, "in {open}{}, {}{close}", Short(low), Short(high))
            }
        }
    }
}

/// A number, displayed with an exponent if that is shorter.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (plain, exponent) = (self.0.to_string(), format!("{:e}", self.0));
        f.write_str(if exponent.len() < plain.len() { &exponent } else { &plain })
    }
}

#[cfg(test)]
mod tests {
    use super::Range;

    #[test]
    fn ends_belong_to_a_range_or_not() {
        for (range, inside, outside, words) in [
            (Range::closed(0.0, 4.0), [0.0, 4.0], [-1e-300, 4.0000001], "in [0, 4]"),
            (Range::left_open(0.0, 8.0), [1e-300, 8.0], [0.0, 8.1], "in (0, 8]"),
            (Range::right_open(-1.0, 1.0), [-1.0, 0.9], [1.0, -1.1], "in [-1, 1)"),
            (Range::closed(0.0, 1e6), [0.0, 1e6], [1e7, -1.0], "in [0, 1e6]"),
            (Range::AT_LEAST_0, [0.0, f64::MAX], [-0.1, f64::INFINITY], "finite and at least 0"),
            (Range::POSITIVE, [5e-324, f64::MAX], [0.0, f64::NAN], "finite and above 0"),
            (Range::FINITE, [f64::MIN, 0.0], [f64::NEG_INFINITY, f64::INFINITY], "a finite number"),
        ] {
            assert!(inside.iter().all(|&x| range.contains(x)), "{range}");
            assert!(outside.iter().all(|&x| !range.contains(x)), "{range}");
            assert_eq!(range.to_string(), words);
        }
    }
}
