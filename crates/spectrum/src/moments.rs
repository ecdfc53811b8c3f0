use crate::ExactSum;

/// Mean and variance of a stream of numbers, bit-identical for any order and grouping.
///
/// The sums of the numbers and of their squares are exact, so the variance does not suffer from
/// cancellation even if the numbers are nearly equal: its relative error is that of one rounding as
/// long as the standard deviation is above 1e-13 of the mean.
///
/// # Examples
///
/// ```
/// use sphvar_spectrum::Moments;
/// let mut moments = Moments::default();
/// for x in [1.0, 2.0, 3.0, 4.0] {
///     moments.push(x);
/// }
/// assert_eq!(moments.mean(), 2.5);
/// assert_eq!(moments.variance(), 5.0 / 3.0);
/// ```
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Moments {
    count: u64,
    sum: ExactSum,
    squares: ExactSum,
}

impl Moments {
    /// Adds a number.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        self.sum.add(x);
        let square = x * x;
        self.squares.add(square);
        if square.is_finite() {
            self.squares.add(x.mul_add(x, -square));
        }
    }

    /// Adds the numbers of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sum.merge(&other.sum);
        self.squares.merge(&other.squares);
    }

    /// Returns the number of numbers added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the mean; NaN if no number was added.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum.value() / self.count as f64
    }

    /// Returns the unbiased variance, with divisor count - 1; NaN for fewer than two numbers.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count < 2 {
            return f64::NAN;
        }
        let n = self.count as f64;
        // n sum x^2 - (sum x)^2 in twice the working precision: first the leading parts, whose
        // difference is exact where it matters, then the rounding errors.
        let (square, square_rest) = self.squares.value_and_rest();
        let (sum, sum_rest) = self.sum.value_and_rest();
        let (a, b) = (n * square, sum * sum);
        let rest =
            n.mul_add(square, -a) + n * square_rest - sum.mul_add(sum, -b) - 2.0 * sum * sum_rest;
        ((a - b) + rest).max(0.0) / (n * (n - 1.0))
    }

    /// Returns the standard error of the mean; NaN for fewer than two numbers.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::Moments;

    #[test]
    fn nearly_equal_numbers_have_an_accurate_variance() {
        let mut moments = Moments::default();
        let spread = 2f64.powi(-40);
        for k in 0..1000 {
            moments.push(30.0 + spread * f64::from(k % 2));
        }
        let expected = spread * spread * 0.25 * 1000.0 / 999.0;
        let got = moments.variance();
        assert!((got / expected - 1.0).abs() < 1e-3, "{got:e}, expected {expected:e}");
    }

    #[test]
    fn fewer_than_two_numbers_have_no_variance() {
        let mut moments = Moments::default();
        assert!(moments.mean().is_nan());
        moments.push(3.0);
        assert!(moments.variance().is_nan() && moments.mean().to_bits() == 3f64.to_bits());
    }
}
