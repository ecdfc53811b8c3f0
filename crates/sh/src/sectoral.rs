use core::f64::consts::PI;

use crate::{Colatitude, Scaled};

/// Returns the constant of the sectoral function: `lambda_mm(theta) = sectoral(m) sin^m(theta)`.
///
/// ```text
/// sectoral(m) = (-1)^m sqrt(1/(4 pi) prod_{k=1}^m (2k + 1)/(2k))
///             = (-1)^m sqrt(R(m) / (2 pi^(3/2))),   R(m) = Gamma(m + 3/2) / Gamma(m + 1)
/// ```
///
/// The sign is the Condon-Shortley phase. The constant grows like `m^(1/4)`, so it is in the range
/// of `f64`. The relative error is a few `EPSILON` for every `m` and does not grow: from `m = 16`
/// on, `R` is computed by its series in `1/(m + 3/4)^2`, truncated at `1.4e-17`, instead of a
/// product of `m` rounded factors.
///
/// # Examples
///
/// ```
/// let s = sphvar_sh::sectoral(1);
/// assert!((s + (3.0 / (8.0 * std::f64::consts::PI)).sqrt()).abs() < 2.0 * f64::EPSILON);
/// ```
///
/// # References
///
/// Tricomi and Erdélyi 1951, doi:10.2140/pjm.1951.1.133; DLMF 5.11.14: the series.
#[must_use]
pub fn sectoral(m: usize) -> f64 {
    /// Coefficients of `w^(-2k)` in `R / sqrt(w)`, `w = m + 3/4`: `binom(1/2, 2k) B_2k^(3/2)(3/4)`.
    const SERIES: [f64; 6] = [
        1.0,
        1.0 / 64.0,
        -19.0 / 8192.0,
        631.0 / 524288.0,
        -174317.0 / 134217728.0,
        20491783.0 / 8589934592.0,
    ];
    const SERIES_FROM: usize = 16;

    let squared = if m < SERIES_FROM {
        let product: f64 = (1..=m).map(|k| (2 * k + 1) as f64 / (2 * k) as f64).product();
        product / (4.0 * PI)
    } else {
        let w = m as f64 + 0.75;
        let inverse = 1.0 / (w * w);
        let sum = SERIES.iter().rev().fold(0.0, |sum, c| sum * inverse + c);
        w.sqrt() * sum / (2.0 * PI * PI.sqrt())
    };
    let magnitude = squared.sqrt();
    if m.is_multiple_of(2) { magnitude } else { -magnitude }
}

/// Returns `lambda_mm(theta) = sectoral(m) sin^m(theta)`, the initial value of the recurrence in
/// `l`.
///
/// The value is the same on both hemispheres. The cost is `O(log m)`.
///
/// # Accuracy
///
/// The sine has a relative error of one `EPSILON` (typically half of that), which the power
/// multiplies by `m`. The power adds at most `(m - 1) EPSILON / 2`, and the constant a few
/// `EPSILON`. The total is below `1.5 m EPSILON + 4 EPSILON`. The stated error of
/// [`lambda`](crate::lambda) is `4 (m + 1) EPSILON`, so plain `f64` products suffice.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Colatitude, sectoral_function};
///
/// let c = Colatitude::from_theta(1e-300)?;
/// let start = sectoral_function(20000, c);
/// assert!((start.log10_abs() + 6e6).abs() < 2.0);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[must_use]
pub fn sectoral_function(m: usize, colatitude: Colatitude) -> Scaled {
    Scaled::new(colatitude.sin(), 0).power(m) * sectoral(m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference: `R(m) = Gamma(m + 3/2)/Gamma(m + 1)` with 20 digits, from the gamma function in
    /// 60-digit arithmetic.
    #[test]
    fn sectoral_constant_against_gamma_functions() {
        let table = include_str!("../tests/data/sectoral.csv");
        let mut rows = 0;
        for line in table.lines().filter(|line| !line.starts_with(['#', 'm'])) {
            let (m, exact) = line.split_once(',').unwrap();
            let (m, exact): (usize, f64) = (m.parse().unwrap(), exact.parse().unwrap());
            let got = sectoral(m);
            // Product: 2 roundings per factor, 15 factors, halved by the root; series: a few.
            let bound = if m < 16 { (m as f64 + 2.0) * f64::EPSILON } else { 3.0 * f64::EPSILON };
            assert!((got / exact - 1.0).abs() <= bound, "m = {m}: {got} against {exact}");
            rows += 1;
        }
        assert_eq!(rows, 40, "the table is complete");
    }
}
