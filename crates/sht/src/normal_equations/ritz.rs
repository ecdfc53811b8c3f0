/// Returns the smallest and the largest eigenvalue of a symmetric tridiagonal matrix, by bisection
/// on the number of negative pivots (Golub and Van Loan 2013, section 8.4.1); `None` if it is
/// empty.
///
/// `off_diagonal` has one entry fewer than `diagonal`; further ones are ignored. The error is the
/// rounding of the largest magnitude.
///
/// # Panics
///
/// Panics if `off_diagonal` is shorter.
#[must_use]
pub fn extreme_eigenvalues(diagonal: &[f64], off_diagonal: &[f64]) -> Option<(f64, f64)> {
    let n = diagonal.len();
    let n_off = n.checked_sub(1)?;
    let off_diagonal = &off_diagonal[..n_off];
    let off = |k: usize| off_diagonal.get(k).map_or(0.0, |x| x.abs());
    let radius = |k: usize| off(k) + if k > 0 { off(k - 1) } else { 0.0 };
    let bound = (0..n).map(|k| diagonal[k].abs() + radius(k)).fold(0.0, f64::max);
    let n_below = |x: f64| {
        let mut pivot = 1.0;
        (0..n)
            .filter(|&k| {
                let square = if k > 0 { off_diagonal[k - 1] * off_diagonal[k - 1] } else { 0.0 };
                // A zero pivot stands for a small negative one.
                let divisor = if pivot == 0.0 { -f64::MIN_POSITIVE } else { pivot };
                pivot = diagonal[k] - x - square / divisor;
                pivot <= 0.0
            })
            .count()
    };
    // The k-th eigenvalue is where the count passes k.
    let eigenvalue = |k: usize| {
        let (mut low, mut high) = (-bound, bound);
        for _ in 0..2 * f64::MANTISSA_DIGITS {
            let middle = f64::midpoint(low, high);
            if n_below(middle) >= k { high = middle } else { low = middle }
        }
        high
    };
    Some((eigenvalue(1), eigenvalue(n)))
}

#[cfg(test)]
mod tests {
    use super::extreme_eigenvalues;

    /// The second difference has the eigenvalues `4 sin^2(k pi/(2n + 2))`.
    #[test]
    fn eigenvalues_of_the_second_difference() {
        for n in [1, 2, 5, 100] {
            let (low, high) = extreme_eigenvalues(&vec![2.0; n], &vec![-1.0; n]).unwrap();
            let exact = |k: usize| {
                let angle = k as f64 * std::f64::consts::FRAC_PI_2 / (n + 1) as f64;
                4.0 * angle.sin().powi(2)
            };
            assert!((low / exact(1) - 1.0).abs() < 1e-11, "{n}: {low}, not {}", exact(1));
            assert!((high / exact(n) - 1.0).abs() < 1e-13, "{n}: {high}, not {}", exact(n));
        }
        assert_eq!(extreme_eigenvalues(&[], &[]), None);
        let (low, high) = extreme_eigenvalues(&[3.0, 3.0], &[0.0]).unwrap();
        assert!((low - 3.0).abs() < 1e-14 && (high - 3.0).abs() < 1e-14, "{low}, {high}");
    }
}
