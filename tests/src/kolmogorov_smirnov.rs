/// Returns the Kolmogorov-Smirnov distance between samples and a distribution function.
///
/// ```text
/// D = max_x |F_n(x) - F(x)|
/// ```
#[must_use]
pub fn ks_distance(samples: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distances = sorted.iter().enumerate().map(|(i, &x)| {
        let (i, f) = (i as f64, cdf(x));
        f64::max((i + 1.0) / n - f, f - i / n)
    });
    distances.fold(0.0, f64::max)
}

/// Returns the probability that `n` samples of the distribution itself are at least this far from
/// it.
///
/// ```text
/// Q(x) = 2 sum_{j >= 1} (-1)^{j-1} e^{-2 j^2 x^2},   x = (sqrt n + 0.12 + 0.11/sqrt n) D
/// ```
///
/// Asymptotic in n; the shift is that of Stephens (1970), accurate to 1e-3 for n >= 8.
#[must_use]
pub fn ks_p_value(n: usize, distance: f64) -> f64 {
    let root = (n as f64).sqrt();
    let x = (root + 0.12 + 0.11 / root) * distance;
    if x < 0.2 {
        // The number of terms of the series diverges, and 1 - Q is below 1e-12.
        return 1.0;
    }
    let term = |j: i32| {
        let sign = if j % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * f64::from(j * j) * x * x).exp()
    };
    (1..=100).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::{ks_distance, ks_p_value};

    #[test]
    fn distance_of_the_definition() {
        let uniform = |x: f64| x;
        // The steps of F_n at 0.2 and 0.9: distances 0.3 at 0.2 and 0.4 just below 0.9.
        let distance = ks_distance(&[0.9, 0.2], uniform);
        assert!((distance - 0.4).abs() < 1e-15, "{distance}");
    }

    /// The 5 % and 1 % points of the limit distribution are 1.3581 and 1.6276.
    #[test]
    fn p_values_of_the_limit_distribution() {
        for (x, p) in [(1.3581, 0.05), (1.6276, 0.01), (0.8276, 0.5)] {
            let n = 1_000_000;
            let got = ks_p_value(n, x / 1000.0);
            assert!((got - p).abs() < 1e-3, "x = {x}: {got}, table {p}");
        }
        assert!(ks_p_value(100, 0.01) > 0.999_999);
    }
}
