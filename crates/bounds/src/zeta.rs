//! Zeta functions and harmonic numbers of real order.
//!
//! Available crates do not cover these: statrs 0.19 sums the harmonic number term by term (`O(n)`)
//! and has no zeta function; special 0.14 has only a trigamma function.

use crate::power_sum::{asymptotic_from, end_correction, power_sum};
use sphvar_sh::CompensatedSum;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Returns the generalised harmonic number of order `s`, any real `s`, zero for `n = 0`.
///
/// ```text
/// H(n, s) = sum_{k=1}^{n} k^-s
/// ```
///
/// Negative `s` gives sums of powers. The relative error is below 1e-14 for `|s| <= 16`; beyond
/// that it grows as `|s| * f64::EPSILON`. Overflows to infinity where the sum does; NaN for NaN.
///
/// # Performance
///
/// About `16 + 2|s|` powers, and never more than about a hundred, for any `n`.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::generalized_harmonic;
/// assert_eq!(generalized_harmonic(3, 1.0), 11.0 / 6.0);
/// assert_eq!(generalized_harmonic(100, -1.0), 5050.0);
/// ```
///
/// # References
///
/// DLMF, section 2.10(i), Euler-Maclaurin formula.
#[must_use]
pub fn generalized_harmonic(n: u64, s: f64) -> f64 {
    let last = n as f64;
    if s.is_nan() {
        f64::NAN
    } else if n == 0 {
        0.0
    } else if s.is_infinite() {
        if s > 0.0 || n == 1 { 1.0 } else { f64::INFINITY }
    } else {
        let sum = power_sum(1.0, last, s);
        sum.reference.powf(-s) * sum.scaled
    }
}

/// Returns the Hurwitz zeta function for `s > 1`, `q > 0`; NaN outside this domain.
///
/// ```text
/// zeta(s, q) = sum_{k>=0} (k + q)^-s
/// ```
///
/// All terms are positive; the relative error is below 1e-14 for `s <= 16`.
///
/// # Performance
///
/// At most `16 + 2s` powers, and never more than about a hundred.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::hurwitz_zeta;
/// let pi = std::f64::consts::PI;
/// assert!((hurwitz_zeta(2.0, 1.0) - pi * pi / 6.0).abs() < 4.0 * f64::EPSILON);
/// assert!(hurwitz_zeta(1.0, 1.0).is_nan());
/// ```
///
/// # References
///
/// DLMF, 25.11.1 and 25.11.43.
#[must_use]
pub fn hurwitz_zeta(s: f64, q: f64) -> f64 {
    if !(s > 1.0 && q > 0.0) {
        return f64::NAN;
    }
    if q.is_infinite() {
        return 0.0;
    }
    let start = asymptotic_from(s);
    let mut sum = CompensatedSum::default();
    let mut x = q;
    while x < start {
        let term = x.powf(-s);
        sum.add(term);
        // From here on the terms fall at least as fast as 2^-k, or the remainder is negligible.
        if term <= f64::EPSILON / 1024.0 * sum.value() {
            return sum.value();
        }
        x += 1.0;
    }
    // x / (s - 1) alone may overflow.
    let term = x.powf(-s);
    sum.add(term * x / (s - 1.0));
    sum.add(term * (0.5 + end_correction(x, s)));
    sum.value()
}

/// Returns the trigamma function `psi_1(x) = zeta(2, x)` for `x > 0`; NaN elsewhere.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::trigamma;
/// assert!((trigamma(0.5) - std::f64::consts::PI.powi(2) / 2.0).abs() < 1e-14);
/// ```
#[must_use]
pub fn trigamma(x: f64) -> f64 {
    hurwitz_zeta(2.0, x)
}

/// Returns the Riemann zeta function of a real argument, continued to `s < 1`; infinite at the pole
/// `s = 1`.
///
/// ```text
/// zeta(s) = sum_{k>=1} k^-s                                            s > 1
/// zeta(s) = (2 pi)^s / pi * sin(pi s / 2) * Gamma(1 - s) * zeta(1 - s)   s < 0
/// ```
///
/// The relative error is below 1e-14 for `0 <= s <= 16` and below 2e-14 for `-16 <= s < 0`, also
/// beside the zeros at the negative even numbers.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::riemann_zeta;
/// assert!((riemann_zeta(-1.0) + 1.0 / 12.0).abs() < 1e-16);
/// assert_eq!(riemann_zeta(-2.0), 0.0);
/// ```
///
/// # References
///
/// DLMF, 25.2.9 and 25.4.1.
#[must_use]
pub fn riemann_zeta(s: f64) -> f64 {
    if s > 1.0 {
        hurwitz_zeta(s, 1.0)
    } else if s >= REFLECT_BELOW {
        riemann_zeta_regular(s) + (s - 1.0).recip()
    } else {
        reflected(s)
    }
}

/// Below this argument the direct form loses digits by cancellation and the functional equation is
/// used; above it, the functional equation would be evaluated near the pole at `1 - s = 1`.
const REFLECT_BELOW: f64 = -0.0625;

/// Returns `zeta(s) - 1/(s - 1)`, which has no pole (Euler's constant at `s = 1`).
pub(crate) fn riemann_zeta_regular(s: f64) -> f64 {
    if s < REFLECT_BELOW {
        return reflected(s) - (s - 1.0).recip();
    }
    let start = asymptotic_from(s);
    let mut sum = CompensatedSum::default();
    let mut k = 1.0;
    while k < start {
        let term = f64::powf(k, -s);
        sum.add(term);
        if term <= f64::EPSILON / 1024.0 {
            break;
        }
        k += 1.0;
    }
    sum.add(start.powf(-s) * (0.5 + end_correction(start, s)));
    // (1 - start^{1-s}) / (1 - s), near s = 1 without the difference.
    let (distance, log) = (1.0 - s, start.ln());
    let t = distance * log;
    sum.add(if t == 0.0 {
        -log
    } else if t.abs() <= 1.0 {
        -log * (t.exp_m1() / t)
    } else {
        (1.0 - start.powf(distance)) / distance
    });
    sum.value()
}

/// Returns the functional equation, with Gamma split by the duplication formula so that it
/// overflows only with the result.
fn reflected(s: f64) -> f64 {
    let x = 1.0 - s;
    // sin(pi s / 2) from the distance to the nearest even number, which is exact.
    let half_periods = (0.5 * s).round();
    let remainder = s - 2.0 * half_periods;
    let sign = if half_periods.rem_euclid(2.0) < 0.5 { 1.0 } else { -1.0 };
    let sine = sign * (FRAC_PI_2 * remainder).sin();
    if sine == 0.0 {
        return 0.0;
    }
    let root = PI.powf(0.5 * s);
    let gammas = (root * gamma(0.5 * x)) * (root * gamma(0.5 * x + 0.5));
    sine * gammas * hurwitz_zeta(x, 1.0) / (PI * PI.sqrt())
}

/// Returns Gamma(x) for `x > 0` from Stirling's series at `x + k >= 16`; the terms left out are
/// below 1e-16.
///
/// The approximation of statrs 0.19 is off by up to 1e-13 between `x = 10` and `x = 50`.
fn gamma(x: f64) -> f64 {
    const FROM: f64 = 16.0;
    let (mut y, mut product) = (x, 1.0);
    while y < FROM {
        product *= y;
        y += 1.0;
    }
    // B_2j / (2j (2j-1)).
    let series =
        [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360360.0];
    let u = (y * y).recip();
    let exponent = series.iter().rev().fold(0.0, |sum, c| sum * u + c) / y;
    // The power is multiplied in two halves, since the whole overflows before Gamma does.
    let half = y.powf(0.5 * (y - 0.5));
    TAU.sqrt() * half * (-y).exp() * half * exponent.exp() / product
}
