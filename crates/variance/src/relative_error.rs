use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal};

/// The relative standard error of a measured variance, and its dependence on the true variance.
///
/// Two kinds of estimates have different errors. For normal estimates `r^2 = 2/(n - 1)`, whatever
/// their variance. If few of the n trials hit the integrand, each with the same contribution, the
/// variance counts these trials: the count k is Poisson distributed with `r^2 = 1/k`, which grows
/// as the true variance decreases. Therefore
///
/// ```text
/// r^2(V) = base + events s^2/V,   base = min(r^2, 2/(n - 1)),   events = r^2 - base
/// ```
///
/// for a measured s^2 and a true V. The corresponding chi-square distribution has `2/r^2` degrees
/// of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeError {
    base: f64,
    events: f64,
}

/// The minimum number of degrees of freedom for a statement about a variance. With fewer than five,
/// when fewer than three or four trials carry the variance, another set of trials may give a
/// variance a thousand times as large.
const MIN_DOF: f64 = 5.0;

/// The number of trials up to which the relative error is at least that of normal estimates,
/// whatever their measured kurtosis: the kurtosis of few trials is hardly known, and three
/// estimates with two different values look like a fair coin.
const FEW_TRIALS: f64 = 30.0;

impl RelativeError {
    /// Returns the relative standard error `relative` for the variance of `trials` estimates.
    ///
    /// For up to 30 trials it is at least that of normal estimates; for n trials its square is at
    /// least `30/n` of theirs.
    #[must_use]
    pub fn new(trials: usize, relative: f64) -> Self {
        let n = trials as f64;
        let normal = 2.0 / (n - 1.0);
        if !(n >= 2.0 && relative >= 0.0) {
            return Self { base: f64::NAN, events: f64::NAN };
        }
        let square = (relative * relative).max(normal * (FEW_TRIALS / n).min(1.0));
        let base = square.min(normal);
        Self { base, events: square - base }
    }

    /// Returns an error of at least `relative`; the part above that of normal estimates is
    /// attributed to events.
    #[must_use]
    pub(crate) fn at_least(self, relative: f64) -> Self {
        let more = relative * relative - self.base - self.events;
        if more > 0.0 { Self { events: self.events + more, ..self } } else { self }
    }

    /// Returns the relative standard error if the true variance equals the measured one.
    #[must_use]
    pub fn relative(self) -> f64 {
        (self.base + self.events).sqrt()
    }

    /// Returns the standard error relative to the true variance, which is `ratio` times the
    /// measured one.
    #[must_use]
    pub fn at(self, ratio: f64) -> f64 {
        (self.base + self.events / ratio).sqrt()
    }

    /// Returns the degrees of freedom of the chi-square distribution with this error, `2/r^2`:
    /// twice the number of trials that carry the variance if they are few, and at most slightly
    /// more than the number of trials.
    #[must_use]
    pub fn dof(self) -> f64 {
        2.0 / (self.base + self.events)
    }

    /// Returns whether the degrees of freedom, at least five, suffice for an interval, a score or a
    /// verdict.
    #[must_use]
    pub fn is_known(self) -> bool {
        self.dof() >= MIN_DOF
    }

    /// Returns the end points of a confidence interval that contains the measured variance.
    ///
    /// ```text
    /// low:  the V of which chi2_nu(1 - a/2)/nu V = s^2,   nu = 2/r^2(V),   a = 1 - confidence
    /// high: nu s^2/chi2_nu(a/2),                          nu = 2/r^2(s^2)
    /// ```
    ///
    /// For normal estimates this is the textbook interval. For a count of k events the lower end is
    /// within 4 % of that of Clopper and Pearson, and the upper end is above theirs, by a third at
    /// k = 5.
    ///
    /// Returns `None` unless [`is_known`](Self::is_known) holds, the variance is above 0 and
    /// finite, and `confidence` is within (0, 1).
    #[must_use]
    pub fn interval(self, variance: f64, confidence: f64) -> Option<(f64, f64)> {
        let is_valid = confidence > 0.0 && confidence < 1.0;
        if !(is_valid && self.is_known() && variance > 0.0 && variance.is_finite()) {
            return None;
        }
        // Medians lie below means, so at low confidence both quantiles do; the interval still
        // contains the measured value.
        let high = 1.0 / relative_quantile(self.dof(), 0.5 - 0.5 * confidence).min(1.0);
        let low = self.lowest_ratio(0.5 + 0.5 * confidence);
        Some((variance * low, variance * high))
    }

    /// Returns the ratio t of true to measured variance, at most 1, for which the measured variance
    /// is the p-quantile.
    fn lowest_ratio(self, p: f64) -> f64 {
        let above = |t: f64| {
            let square = self.at(t).powi(2);
            t * relative_quantile(2.0 / square, p) >= 1.0
        };
        let (mut low, mut high) = (0.0, 1.0);
        // Bisect to more digits than an interval needs.
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if above(middle) { high = middle } else { low = middle }
        }
        high
    }
}

/// Returns the largest probability, at 97.5 % confidence, of an event that did not occur in n
/// trials: `1 - 0.025^(1/n)`, about 3.7/n; 1 without trials.
#[must_use]
pub fn rarest_seen(trials: usize) -> f64 {
    -(0.025_f64.ln() / trials as f64).exp_m1()
}

/// Returns the chi-square quantile divided by the number of degrees of freedom.
fn relative_quantile(dof: f64, p: f64) -> f64 {
    chi_square_quantile(dof, p) / dof
}

/// Returns the chi-square quantile for any positive number of degrees of freedom.
fn chi_square_quantile(dof: f64, p: f64) -> f64 {
    const MANY: f64 = 50.0;
    const VERY_MANY: f64 = 1e4;
    let Ok(chi_square) = ChiSquared::new(dof) else {
        return f64::NAN;
    };
    if dof <= MANY {
        return chi_square.inverse_cdf(p);
    }
    // Wilson and Hilferty (1931): within 2e-3 of the quantile at 50 degrees of freedom, 1e-5 at
    // 10000. Two Newton steps from this value are much faster than bisection of the distribution
    // function.
    let ninth = 2.0 / (9.0 * dof);
    let near = dof * (1.0 - ninth + Normal::standard().inverse_cdf(p) * ninth.sqrt()).powi(3);
    let newton = |x: f64| x - (chi_square.cdf(x) - p) / chi_square.pdf(x);
    if dof <= VERY_MANY { newton(newton(near)) } else { near }
}

#[cfg(test)]
mod tests {
    use super::{RelativeError, chi_square_quantile, rarest_seen};

    /// From tables: 79.490 and 27.991 at 99.5 and 0.5 % of 50 degrees of freedom, 129.561 at 97.5 %
    /// of 100.
    #[test]
    fn chi_square_quantiles_match_tables() {
        for (dof, p, table) in [
            (50.0, 0.995, 79.490),
            (50.0, 0.005, 27.991),
            (50.001, 0.995, 79.490),
            (50.001, 0.005, 27.991),
            (100.0, 0.975, 129.561),
            (10.0, 0.025, 3.2470),
            (1000.0, 0.975, 1089.531),
            (1000.0, 0.005, 888.564),
        ] {
            let got = chi_square_quantile(dof, p);
            // The tables have five digits, and the quantile changes by one in 50 per degree of
            // freedom.
            assert!((got / table - 1.0).abs() < 1e-4, "{dof}, {p}: {got}, table {table}");
        }
    }

    /// The textbook interval for 20 normal estimates is 19 s^2/32.852 to 19 s^2/8.9065.
    #[test]
    fn normal_estimates_have_the_textbook_interval() {
        let error = RelativeError::new(20, (2.0f64 / 19.0).sqrt());
        let (low, high) = error.interval(3.0, 0.95).unwrap();
        assert!((low / (3.0 * 19.0 / 32.852) - 1.0).abs() < 1e-4, "{low}");
        assert!((high / (3.0 * 19.0 / 8.9065) - 1.0).abs() < 1e-4, "{high}");
    }

    /// Clopper and Pearson (scipy): the interval for 5 events in many trials is 1.6235 to 11.668,
    /// for 50 events 37.11 to 65.92.
    #[test]
    fn intervals_of_counts_contain_the_exact_ones() {
        for (k, low, high) in [(5.0f64, 1.6235, 11.668), (50.0, 37.111, 65.919)] {
            let got = RelativeError::new(1_000_000, k.recip().sqrt()).interval(k, 0.95).unwrap();
            assert!((got.0 / low - 1.0).abs() < 0.04, "{k}: {got:?}");
            assert!((1.0..1.35).contains(&(got.1 / high)), "{k}: {got:?}");
        }
    }

    #[test]
    fn few_events_have_no_interval() {
        // Three events in 1000 trials give 6 degrees of freedom, two give four.
        assert!(RelativeError::new(1000, (1.0f64 / 3.0).sqrt()).is_known());
        let few = RelativeError::new(1000, 0.5f64.sqrt());
        assert!(!few.is_known() && few.interval(1.0, 0.95).is_none());
        for relative in [f64::NAN, f64::INFINITY, 1e200] {
            assert!(RelativeError::new(1000, relative).interval(1.0, 0.95).is_none(), "{relative}");
        }
        assert!(RelativeError::new(0, 0.1).interval(1.0, 0.95).is_none());
        // The probability of no event is 2.5 %.
        assert!(((1.0 - rarest_seen(2000)).powi(2000) - 0.025).abs() < 1e-12);
        assert!((rarest_seen(0) - 1.0).abs() < 1e-15);
    }
}
