use sphvar_variance::student_quantile;

/// A number with its 95 % interval, which is the number itself if it is exact, and NaN if its error
/// is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// The value.
    pub value: f64,
    /// The end points.
    pub interval: (f64, f64),
}

/// The standard normal quantile of 97.5 %.
const Z95: f64 = 1.959_963_984_540_054;

impl Quantity {
    /// Returns a value that is exact.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self { value, interval: (value, value) }
    }

    /// Returns a single random value, without an interval.
    #[must_use]
    pub fn single(value: f64) -> Self {
        Self { value, interval: (f64::NAN, f64::NAN) }
    }

    /// Returns a value with a standard error.
    #[must_use]
    pub fn with_stderr(value: f64, stderr: f64) -> Self {
        Self::within(value, Z95 * stderr)
    }

    /// Returns a value with a standard error that was estimated from data with `dof` degrees of
    /// freedom: the interval of Student's t, NaN without degrees of freedom.
    #[must_use]
    pub fn with_student(value: f64, stderr: f64, dof: f64) -> Self {
        Self::within(value, student_quantile(0.975, dof) * stderr)
    }

    fn within(value: f64, half: f64) -> Self {
        Self { value, interval: (value - half, value + half) }
    }
}

#[cfg(test)]
mod tests {
    use super::Quantity;

    /// Two-sided 5 % of Student's t: 12.706 with one degree of freedom, 2.571 with five (any
    /// table).
    #[test]
    fn few_renders_have_wide_intervals() {
        for (dof, quantile) in [(1.0, 12.706), (5.0, 2.571)] {
            let got = Quantity::with_student(3.0, 2.0, dof);
            // Half a unit of the tables' last digit.
            assert!((got.interval.1 - 3.0 - 2.0 * quantile).abs() < 1e-3, "{dof}: {got:?}");
            assert!((got.interval.0 + got.interval.1 - 6.0).abs() < 1e-12, "{dof}: {got:?}");
        }
        assert!(Quantity::with_student(3.0, 2.0, 0.0).interval.0.is_nan());
    }
}
