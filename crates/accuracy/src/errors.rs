/// Errors of many values: the largest, where it is, and the root of the mean square.
///
/// ```
/// use sphvar_accuracy::Errors;
/// let mut errors = Errors::default();
/// errors.push(3e-16, || "theta = 1".to_owned());
/// errors.push(-4e-16, || "theta = 2".to_owned());
/// assert_eq!(errors.max(), 4e-16);
/// assert_eq!(errors.worst(), "theta = 2");
/// assert!((errors.rms() / 12.5e-32f64.sqrt() - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    max: f64,
    worst: String,
    squares: f64,
    count: u64,
}

impl Errors {
    /// Takes in the error of one value; `name` says which one, and is asked only if no other was as large. A NaN
    /// counts as an infinite error: a bound must not pass over it.
    pub fn push(&mut self, error: f64, name: impl FnOnce() -> String) {
        let size = if error.is_nan() { f64::INFINITY } else { error.abs() };
        if self.count == 0 || size > self.max {
            self.max = size;
            self.worst = name();
        }
        self.squares += size * size;
        self.count += 1;
    }

    /// Takes in an infinite error if `got` values came where `expected` ones should: a bound must not pass over those
    /// that are missing.
    pub(crate) fn push_length(&mut self, got: usize, expected: usize) {
        if got != expected {
            self.push(f64::NAN, || format!("{got} values, not {expected}"));
        }
    }

    /// The largest magnitude; 0 of no values.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The name of the value with the largest error.
    #[must_use]
    pub fn worst(&self) -> &str {
        &self.worst
    }

    /// The root of the mean square; 0 of no values.
    #[must_use]
    pub fn rms(&self) -> f64 {
        if self.count == 0 { 0.0 } else { (self.squares / self.count as f64).sqrt() }
    }

    /// The number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::Errors;

    #[test]
    fn missing_values_are_infinite_errors() {
        let mut errors = Errors::default();
        errors.push_length(3, 3);
        assert_eq!(errors, Errors::default());
        errors.push(1.0, || "a value".to_owned());
        errors.push_length(2, 3);
        assert_eq!((errors.max(), errors.worst()), (f64::INFINITY, "2 values, not 3"));
    }
}
