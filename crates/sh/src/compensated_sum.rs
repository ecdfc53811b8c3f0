/// A running sum with compensation of the rounding error of every addition (Neumaier 1974).
///
/// For terms of one sign the result has a relative error of a few `f64::EPSILON`, for any number
/// and order of terms.
///
/// # Examples
///
/// ```
/// use sphvar_sh::CompensatedSum;
/// let sum: CompensatedSum = [1.0, 1e100, 1.0, -1e100].into_iter().collect();
/// assert_eq!(sum.value(), 2.0);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct CompensatedSum {
    sum: f64,
    correction: f64,
}

impl CompensatedSum {
    /// Adds a term.
    #[inline]
    pub fn add(&mut self, term: f64) {
        let total = self.sum + term;
        self.correction += if self.sum.abs() >= term.abs() {
            (self.sum - total) + term
        } else {
            (term - total) + self.sum
        };
        self.sum = total;
    }

    /// Returns the sum.
    #[must_use]
    pub fn value(self) -> f64 {
        // After an overflow the correction is NaN, but the plain sum is infinite.
        if self.sum.is_finite() { self.sum + self.correction } else { self.sum }
    }
}

impl FromIterator<f64> for CompensatedSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        terms.into_iter().for_each(|t| sum.add(t));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_that_a_plain_sum_loses_are_kept() {
        let sum: CompensatedSum = [1.0, 1e100, 1.0, -1e100].into_iter().collect();
        assert_eq!(sum.value().to_bits(), 2.0_f64.to_bits());
        let infinite: CompensatedSum = [f64::MAX, f64::MAX].into_iter().collect();
        assert!(infinite.value().is_infinite(), "got {}", infinite.value());
    }
}
