/// Statistics of the errors of many values: the maximum, its location, and the root mean square.
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
    /// Adds the error of one value. `name` identifies the value and is called only if the error is
    /// the largest so far. A NaN counts as an infinite error, so that it exceeds any bound.
    pub fn push(&mut self, error: f64, name: impl FnOnce() -> String) {
        let size = if error.is_nan() { f64::INFINITY } else { error.abs() };
        if self.count == 0 || size > self.max {
            self.max = size;
            self.worst = name();
        }
        self.squares += size * size;
        self.count += 1;
    }

    /// Adds an infinite error unless the number of values `got` equals `expected`, so that missing
    /// values exceed any bound.
    pub(crate) fn push_length(&mut self, got: usize, expected: usize) {
        if got != expected {
            self.push(f64::NAN, || format!("{got} values, not {expected}"));
        }
    }

    /// Returns the largest magnitude; 0 without values.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Returns the name of the value with the largest error.
    #[must_use]
    pub fn worst(&self) -> &str {
        &self.worst
    }

    /// Returns the root mean square; 0 without values.
    #[must_use]
    pub fn rms(&self) -> f64 {
        if self.count == 0 { 0.0 } else { (self.squares / self.count as f64).sqrt() }
    }

    /// Returns the number of values.
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
