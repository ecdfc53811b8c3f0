use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Returns the two-sided critical value of the largest |z| among independent normal comparisons.
///
/// ```text
/// P(max_{i <= k} |z_i| > sidak_z(alpha, k)) = alpha
/// ```
///
/// With any dependence between the comparisons the probability is at most alpha (Sidak 1967).
#[must_use]
pub fn sidak_z(alpha: f64, comparisons: usize) -> f64 {
    // 1 - (1 - alpha)^(1/k) without the rounding of numbers near 1.
    let single = -((-alpha).ln_1p() / comparisons as f64).exp_m1();
    -Normal::standard().inverse_cdf(0.5 * single)
}

/// Returns the central interval that chi-square per degree of freedom leaves with probability
/// `alpha`.
///
/// # Panics
///
/// If `dof` is 0.
#[must_use]
pub fn chi2_interval(dof: usize, alpha: f64) -> (f64, f64) {
    let distribution = chi_square(dof);
    let per_dof = |p: f64| distribution.inverse_cdf(p) / dof as f64;
    (per_dof(0.5 * alpha), per_dof(1.0 - 0.5 * alpha))
}

/// Returns the probability that chi-square per degree of freedom falls outside `[low, high]`.
///
/// # Panics
///
/// If `dof` is 0.
#[must_use]
pub fn chi2_false_alarm(dof: usize, low: f64, high: f64) -> f64 {
    let distribution = chi_square(dof);
    distribution.cdf(low * dof as f64) + distribution.sf(high * dof as f64)
}

fn chi_square(dof: usize) -> ChiSquared {
    ChiSquared::new(dof as f64).expect("at least one degree of freedom")
}

#[cfg(test)]
mod tests {
    use super::{chi2_false_alarm, chi2_interval, sidak_z};

    /// Quantiles from tables: z(0.05) = 1.959964; ten comparisons at 5 % each give 1 - 0.95^10.
    #[test]
    fn quantiles_match_tables() {
        for (alpha, k, z) in
            [(0.05, 1, 1.959964), (1.0 - 0.95_f64.powi(10), 10, 1.959964), (2.7e-3, 1, 2.999_977)]
        {
            let got = sidak_z(alpha, k);
            assert!((got - z).abs() < 1e-5, "alpha {alpha}, {k} comparisons: {got}, table {z}");
        }
        // Chi-square with 10 degrees of freedom: 3.247 and 20.483 at 2.5 and 97.5 %.
        let (low, high) = chi2_interval(10, 0.05);
        assert!((low - 0.3247).abs() < 1e-4 && (high - 2.0483).abs() < 1e-4, "{low}, {high}");
        let alarm = chi2_false_alarm(10, low, high);
        assert!((alarm - 0.05).abs() < 1e-6, "{alarm}");
    }
}
