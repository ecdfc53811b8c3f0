use crate::sidak_z;

/// A family of z-scores that are judged together: the largest one against its Sidak limit.
#[derive(Clone, Debug)]
pub struct Family {
    name: &'static str,
    scores: Vec<f64>,
    worst: String,
    largest: f64,
}

impl Family {
    /// Returns an empty family; the name appears in the message of a failure.
    #[must_use]
    pub fn new(name: &'static str) -> Self {
        Self { name, scores: Vec::new(), worst: String::new(), largest: -1.0 }
    }

    /// Adds the comparison of an estimate with its expectation, in units of its standard error.
    ///
    /// # Panics
    ///
    /// Panics if the score is not finite, as for a standard error of 0.
    pub fn compare(
        &mut self,
        estimate: f64,
        expected: f64,
        stderr: f64,
        label: impl FnOnce() -> String,
    ) {
        let z = (estimate - expected) / stderr;
        assert!(
            z.is_finite(),
            "{}: {}: {estimate:e}, expected {expected:e} +- {stderr:e}",
            self.name,
            label()
        );
        self.scores.push(z);
        if z.abs() > self.largest {
            self.largest = z.abs();
            self.worst = format!("{}: {estimate:e}, expected {expected:e} +- {stderr:e}", label());
        }
    }

    /// Returns the scores in insertion order.
    #[must_use]
    pub fn scores(&self) -> &[f64] {
        &self.scores
    }

    /// Asserts that no score exceeds its Sidak limit; fails by chance with probability at most
    /// `alpha` if the scores are normal.
    ///
    /// # Panics
    ///
    /// Panics if a score exceeds the limit, or if there are no scores.
    pub fn assert_null(&self, alpha: f64) {
        let count = self.scores.len();
        assert!(count > 0, "{}: nothing was compared", self.name);
        let limit = sidak_z(alpha, count);
        assert!(
            self.largest <= limit,
            "{}: |z| = {:.2} above {limit:.2} ({count} comparisons, alpha {alpha}): {}",
            self.name,
            self.largest,
            self.worst
        );
    }
}

#[cfg(test)]
mod tests {
    use super::Family;

    #[test]
    fn within_the_limit_nothing_happens() {
        let mut family = Family::new("z");
        family.compare(1.0, 0.0, 0.5, || "two sigma".into());
        family.compare(0.0, 2.0, 1.0, || "minus two sigma".into());
        family.assert_null(0.05);
        assert!(family.scores().iter().map(|z| z.abs()).sum::<f64>() > 3.99);
    }

    #[test]
    #[should_panic(expected = "the bad one")]
    fn beyond_the_limit_the_worst_is_named() {
        let mut family = Family::new("z");
        family.compare(1.0, 0.0, 0.5, || "a good one".into());
        family.compare(0.0, 4.0, 1.0, || "the bad one".into());
        family.assert_null(0.01);
    }

    #[test]
    #[should_panic(expected = "no spread")]
    fn a_score_without_a_scale_panics() {
        Family::new("z").compare(1.0, 1.0, 0.0, || "no spread".into());
    }
}
