/// A number with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// The standard error; NaN if unknown.
    pub stderr: f64,
}

impl Estimate {
    /// Returns `value` from `count` independent replications with its jackknife standard error;
    /// `without(i)` is the value from all replications except i. The error is NaN for fewer than
    /// two replications. For a mean it equals the standard formula.
    pub(crate) fn jackknife(value: f64, count: usize, without: impl Fn(usize) -> f64) -> Self {
        let values: Vec<f64> = (0..count).map(without).collect();
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let scatter: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let stderr = if count < 2 { f64::NAN } else { ((n - 1.0) / n * scatter).sqrt() };
        // Identical replications scatter by the rounding of their sums.
        let stderr = if stderr < n * f64::EPSILON * value.abs() { 0.0 } else { stderr };
        Self { value, stderr }
    }
}

#[cfg(test)]
mod tests {
    use super::Estimate;

    #[test]
    fn the_jackknife_error_of_a_mean_is_its_standard_error() {
        let x = [1.0, 2.0, 4.0, 9.0];
        let without = |i: usize| (16.0 - x[i]) / 3.0;
        let got = Estimate::jackknife(4.0, 4, without);
        // Squared deviations add up to 38; the tolerance covers several roundings.
        let expected = (38.0f64 / 3.0 / 4.0).sqrt();
        assert!((got.stderr / expected - 1.0).abs() < 8.0 * f64::EPSILON, "{got:?}");
        assert!(Estimate::jackknife(1.0, 1, |_| f64::NAN).stderr.is_nan());
    }
}
