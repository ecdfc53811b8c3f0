/// The first terms of a power series.
pub(super) type Series<const M: usize> = [f64; M];

/// Returns the product of two series.
pub(super) fn product<const M: usize>(a: &Series<M>, b: &Series<M>) -> Series<M> {
    std::array::from_fn(|n| (0..=n).map(|i| a[i] * b[n - i]).sum())
}

/// Returns the series of `exp(rate x)`.
pub(super) fn exponential<const M: usize>(rate: f64) -> Series<M> {
    let mut term = 1.0;
    std::array::from_fn(|n| {
        if n > 0 {
            term *= rate / n as f64;
        }
        term
    })
}

/// Returns the quotient `a/b`; the constant term of `b` is 1.
pub(super) fn quotient<const M: usize>(a: &Series<M>, b: &Series<M>) -> Series<M> {
    let mut out = [0.0; M];
    for n in 0..M {
        out[n] = a[n] - (0..n).map(|i| out[i] * b[n - i]).sum::<f64>();
    }
    out
}

/// Returns the value of a series.
pub(super) fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::{exponential, product, quotient, value};

    #[test]
    fn operations_are_those_of_functions() {
        let (a, b) = (exponential::<24>(0.7), exponential::<24>(-1.3));
        for x in [-0.8, 0.0, 0.5, 1.0] {
            let near = |got: f64, expected: f64| {
                assert!((got / expected - 1.0).abs() < 1e-14, "{x}: {got}, {expected}");
            };
            near(value(&product(&a, &b), x), (-0.6 * x).exp());
            near(value(&quotient(&a, &b), x), (2.0 * x).exp());
        }
    }
}
