use crate::{RelativeError, student};

/// Estimates of one integral from independent trials of a pattern.
///
/// [`of_vector`](Self::of_vector) makes one of several integrals. Its estimates are norms, its
/// deviations are distances of vectors, and its variance is the sum of the variances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    estimates: Vec<f64>,
    vector: Option<VectorMoments>,
}

/// The mean and the deviations of vectors.
#[derive(Clone, Debug, PartialEq)]
struct VectorMoments {
    /// The norm of the mean.
    mean: f64,
    /// The distance of each estimate from the mean.
    distances: Vec<f64>,
}

impl Measurement {
    /// Returns the measurement consisting of the estimates of independent trials.
    #[must_use]
    pub fn new(estimates: Vec<f64>) -> Self {
        Self { estimates, vector: None }
    }

    /// Returns the measurement of a vector of integrals from measurements of its components on the
    /// same trials, each multiplied by a weight. Its variance is the mean squared distance of an
    /// estimate from the mean, `sum_c (a_c s_c)^2`; its mean is the norm of the mean vector.
    ///
    /// # Panics
    ///
    /// Panics if the numbers of trials differ.
    #[must_use]
    pub fn of_vector(components: &[Self], weights: &[f64]) -> Self {
        let trials = components.first().map_or(0, |first| first.estimates.len());
        let mut squares = vec![0.0; trials];
        let (mut distances, mut mean) = (squares.clone(), 0.0);
        for (component, weight) in components.iter().zip(weights) {
            assert_eq!(component.estimates.len(), trials, "components have the same trials");
            let centre = component.mean();
            mean += (weight * centre).powi(2);
            for (i, estimate) in component.estimates.iter().enumerate() {
                squares[i] += (weight * estimate).powi(2);
                distances[i] += (weight * (estimate - centre)).powi(2);
            }
        }
        let roots = |squares: Vec<f64>| squares.into_iter().map(f64::sqrt).collect();
        let vector = VectorMoments { mean: f64::sqrt(mean), distances: roots(distances) };
        Self { estimates: roots(squares), vector: Some(vector) }
    }

    /// Returns whether the estimates are those of a vector.
    #[must_use]
    pub fn is_of_vector(&self) -> bool {
        self.vector.is_some()
    }

    /// Returns the estimates in the order of the trials.
    #[must_use]
    pub fn estimates(&self) -> &[f64] {
        &self.estimates
    }

    /// Returns the mean estimate; NaN without trials.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if let Some(vector) = &self.vector {
            return vector.mean;
        }
        // The second pass removes the rounding error of the first.
        let rough = self.estimates.iter().sum::<f64>() / self.count();
        rough + self.estimates.iter().map(|x| x - rough).sum::<f64>() / self.count()
    }

    /// Returns the standard error of the mean; NaN for fewer than two trials.
    #[must_use]
    pub fn mean_stderr(&self) -> f64 {
        (self.variance() / self.count()).sqrt()
    }

    /// Returns the unbiased variance of the estimates, with divisor count - 1; NaN for fewer than
    /// two trials.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.estimates.len() < 2 { f64::NAN } else { self.squares() / (self.count() - 1.0) }
    }

    /// Returns the standard error of the variance, from the fourth moment of the estimates:
    /// `Var s^2 = (mu_4 - sigma^4 (n-3)/(n-1))/n`. NaN for fewer than four trials.
    ///
    /// No distribution has a smaller fourth moment than a fair coin, for which `mu_4 = sigma^4`.
    /// Where the moments of the trials are below it, the corresponding value `2 sigma^4/(n (n-1))`
    /// is used.
    #[must_use]
    pub fn variance_stderr(&self) -> f64 {
        self.variance() * self.relative_stderr()
    }

    /// Returns the standard error of the variance relative to the variance; 0 if all estimates are
    /// equal, NaN for fewer than four trials.
    #[must_use]
    pub fn relative_stderr(&self) -> f64 {
        let n = self.count();
        if n < 4.0 {
            return f64::NAN;
        }
        let kurtosis = self.kurtosis();
        if kurtosis.is_nan() {
            return self.variance() * 0.0;
        }
        // s^2 has the divisor n - 1, the kurtosis n.
        let fourth = kurtosis * ((n - 1.0) / n).powi(2);
        ((fourth - (n - 3.0) / (n - 1.0)).max(2.0 / (n - 1.0)) / n).sqrt()
    }

    /// Returns the kurtosis of the estimates, `n sum d^4/(sum d^2)^2` for their deviations d: 3 for
    /// normal estimates, n/k where k of n deviate equally and the others hardly at all. NaN if all
    /// estimates are equal.
    #[must_use]
    pub fn kurtosis(&self) -> f64 {
        let deviations = self.deviations();
        let largest = deviations.iter().fold(0.0, |max: f64, d| max.max(d.abs()));
        // Relative to the largest deviation, so that no power overflows or underflows.
        let squares = || deviations.iter().map(|d| (d / largest).powi(2));
        let (second, fourth) = (squares().sum::<f64>(), squares().map(|q| q * q).sum::<f64>());
        self.count() * fourth / (second * second)
    }

    /// Returns the relative standard error of the variance from the leave-one-out jackknife of
    /// `ln s^2` (Miller 1968), with
    ///
    /// ```text
    /// s^2_(i) = ((n-1) s^2 - d_i^2 n/(n-1))/(n-2),   d_i the deviation of trial i
    /// Var ln s^2 = (n-1)/n sum_i (ln s^2_(i) - mean)^2
    /// ```
    ///
    /// It needs no fourth moment, and it is the larger estimate where few trials carry the
    /// variance. It is infinite if a single trial carries all of it, and NaN for fewer than four
    /// trials.
    #[must_use]
    pub fn jackknife_relative_stderr(&self) -> f64 {
        let n = self.count();
        if n < 4.0 {
            return f64::NAN;
        }
        let sum = self.squares();
        if sum <= 0.0 {
            return 0.0;
        }
        let logs: Vec<f64> = self
            .deviations()
            .iter()
            .map(|d| (1.0 - (d * d / sum * n / (n - 1.0)).min(1.0)).ln())
            .collect();
        if logs.contains(&f64::NEG_INFINITY) {
            return f64::INFINITY;
        }
        let centre = logs.iter().sum::<f64>() / n;
        ((n - 1.0) / n * logs.iter().map(|x| (x - centre).powi(2)).sum::<f64>()).sqrt()
    }

    /// Returns the relative error of the variance, as estimated from the trials: the larger of the
    /// jackknife estimate, which has better coverage for heavy-tailed distributions, and the
    /// estimate from the fourth moment.
    #[must_use]
    pub fn relative_error(&self) -> RelativeError {
        let relative = self.jackknife_relative_stderr().max(self.relative_stderr());
        RelativeError::new(self.estimates.len(), relative)
    }

    /// Returns the end points of a confidence interval for the variance, which always contains the
    /// measured value; see [`RelativeError::interval`].
    ///
    /// Returns `None` if too few trials carry the variance ([`RelativeError::is_known`]), if all
    /// estimates are equal (which shows only that other values are rare:
    /// [`rarest_seen`](crate::rarest_seen)), or if `confidence` is not within (0, 1).
    #[must_use]
    pub fn variance_interval(&self, confidence: f64) -> Option<(f64, f64)> {
        self.relative_error().interval(self.variance(), confidence)
    }

    /// Returns the test of the mean of the estimates against the exact integral.
    ///
    /// `rounding` is the variance that rounding can produce in one estimate. It is added to the
    /// standard error without division by the square root of the number of trials, as rounding
    /// errors need not be independent.
    #[must_use]
    pub fn bias(&self, exact: f64, rounding: f64) -> BiasTest {
        let z = (self.mean() - exact) / self.mean_stderr().hypot(rounding.sqrt());
        if z.is_nan() {
            return BiasTest { z, p_value: f64::NAN };
        }
        BiasTest { z, p_value: student::two_sided(z, self.count() - 1.0) }
    }

    /// Returns the estimate that a share `p` of the trials does not exceed, by linear interpolation
    /// between the ordered estimates (Hyndman and Fan 1996, definition 7). Returns `None` where
    /// less than one trial is expected below or above it: for p = 5 % with fewer than 20 trials.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_variance::Measurement;
    ///
    /// let trials = Measurement::new(vec![4.0, 1.0, 3.0, 2.0, 5.0]);
    /// assert_eq!(trials.quantile(0.25), Some(2.0));
    /// assert_eq!(trials.quantile(0.05), None);
    /// ```
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the number of trials"
    )]
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let is_known = p.min(1.0 - p) * self.count() >= 1.0 - 1e-9;
        if !is_known {
            return None;
        }
        let mut sorted = self.estimates.clone();
        sorted.sort_by(f64::total_cmp);
        let place = p * (self.count() - 1.0);
        let below = (place as usize).min(sorted.len() - 1);
        let above = (below + 1).min(sorted.len() - 1);
        let fraction = place - below as f64;
        // A difference may overflow or, between equal estimates, leave rounding errors.
        Some(sorted[below] * (1.0 - fraction) + sorted[above] * fraction)
    }

    /// Returns the number of trials at which the relative standard error of the variance is
    /// `relative`, given the kurtosis of the present estimates: `n (r/relative)^2`.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates, and NaN needs no trials"
    )]
    pub fn trials_for(&self, relative: f64) -> u64 {
        (self.count() * (self.relative_error().relative() / relative).powi(2)).ceil() as u64
    }

    /// Adds the estimates of further trials of one integral.
    pub fn extend(&mut self, estimates: impl IntoIterator<Item = f64>) {
        self.estimates.extend(estimates);
    }

    /// Returns the sum of squared deviations.
    fn squares(&self) -> f64 {
        self.deviations().iter().map(|d| d.powi(2)).sum()
    }

    /// Returns the deviations of the estimates from the mean, distances for vectors.
    fn deviations(&self) -> Vec<f64> {
        if let Some(vector) = &self.vector {
            return vector.distances.clone();
        }
        let mean = self.mean();
        self.estimates.iter().map(|x| x - mean).collect()
    }

    fn count(&self) -> f64 {
        self.estimates.len() as f64
    }
}

/// The outcome of testing the mean of estimates against the integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasTest {
    /// Mean minus integral in standard errors; NaN for fewer than two trials.
    pub z: f64,
    /// The probability of a |z| at least as large without bias (Student's t).
    pub p_value: f64,
}

#[cfg(test)]
mod tests {
    use super::Measurement;

    #[test]
    fn equal_estimates_have_no_bias_test() {
        for estimates in [vec![], vec![0.0], vec![0.0; 10]] {
            let got = Measurement::new(estimates).bias(0.0, 0.0);
            assert!(got.z.is_nan() && got.p_value.is_nan(), "{got:?}");
        }
    }

    #[test]
    fn moments_are_those_of_the_definition() {
        let m = Measurement::new(vec![1.0, 2.0, 4.0, 9.0]);
        assert!((m.mean() - 4.0).abs() < 1e-15);
        // Deviations -3, -2, 0, 5: squares 38, fourth powers 722.
        assert!((m.variance() - 38.0 / 3.0).abs() < 1e-14);
        let square = (38.0f64 / 3.0).powi(2);
        let expected = ((722.0 / 4.0 - square / 3.0) / 4.0).sqrt();
        assert!((m.variance_stderr() - expected).abs() < 1e-14);
    }

    #[test]
    fn the_jackknife_equals_its_definition() {
        let values = [1.0, 2.0, 4.0, 9.0, -3.0];
        let n = values.len() as f64;
        let logs: Vec<f64> = (0..values.len())
            .map(|i| {
                let rest = values.iter().enumerate().filter(|p| p.0 != i).map(|p| *p.1).collect();
                Measurement::new(rest).variance().ln()
            })
            .collect();
        let centre = logs.iter().sum::<f64>() / n;
        let square = (n - 1.0) / n * logs.iter().map(|x| (x - centre).powi(2)).sum::<f64>();
        let got = Measurement::new(values.to_vec()).jackknife_relative_stderr();
        // About ten roundings of numbers of order 1.
        assert!((got / square.sqrt() - 1.0).abs() < 20.0 * f64::EPSILON, "{got}, {square}");
    }

    #[test]
    fn degenerate_trials_have_degenerate_errors() {
        let same = Measurement::new(vec![2.0; 10]);
        assert!(same.variance_stderr() == 0.0 && same.relative_stderr() == 0.0);
        assert_eq!(same.variance_interval(0.95), None);
        let few = Measurement::new(vec![1.0, 2.0, 3.0]);
        assert!(few.relative_stderr().is_nan() && few.variance_interval(0.95).is_none());
        let coin = Measurement::new((0..100).map(|k| f64::from(k % 2)).collect());
        // The smallest possible value, 2/(n (n-1)).
        let smallest = (2.0 / (100.0 * 99.0_f64)).sqrt();
        assert!(
            (coin.relative_stderr() / smallest - 1.0).abs() < 1e-12,
            "{}",
            coin.relative_stderr()
        );
        for confidence in [0.0, 1.0, -1.0, 2.0, f64::NAN, f64::INFINITY] {
            assert!(coin.variance_interval(confidence).is_none(), "{confidence}");
        }
        let alone = Measurement::new((0..10).map(|k| f64::from(u8::from(k == 0))).collect());
        assert!(alone.variance_interval(0.95).is_none());
    }

    /// Student's t with 3 degrees of freedom has 5 % beyond 3.182.
    #[test]
    fn the_bias_test_is_students() {
        let m = Measurement::new(vec![1.0, 2.0, 4.0, 9.0]);
        let test = m.bias(m.mean() - 3.182_446_3 * m.mean_stderr(), 0.0);
        assert!(
            (test.z - 3.182_446_3).abs() < 1e-9 && (test.p_value - 0.05).abs() < 1e-7,
            "{test:?}"
        );
        // Rounding alone is not a bias.
        let m = Measurement::new(vec![1.0; 5]);
        let test = m.bias(1.0 + f64::EPSILON, f64::EPSILON * f64::EPSILON);
        assert!(test.z.abs() <= 1.0 && test.p_value > 0.3, "{test:?}");
    }

    #[test]
    fn a_common_offset_does_not_change_the_variance() {
        let offset = 1e8;
        let m = Measurement::new((0..100).map(|k| offset + 1e-6 * f64::from(k % 2)).collect());
        // Deviations round to offset EPSILON = 2e-8, one part in 50.
        assert!((m.variance() / (0.25e-12 * 100.0 / 99.0) - 1.0).abs() < 0.1, "{:e}", m.variance());
    }
}
