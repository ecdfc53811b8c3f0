//! Sums of real powers of consecutive integers, by some direct terms and the Euler-Maclaurin
//! formula.

use sphvar_sh::CompensatedSum;

/// `B_2j / (2j)!` for `j = 1, 2, ...`, `B` the Bernoulli numbers.
const EULER_MACLAURIN: [f64; 10] = [
    1.0 / 12.0,
    -1.0 / 720.0,
    1.0 / 30240.0,
    -1.0 / 1209600.0,
    1.0 / 47900160.0,
    -691.0 / 1307674368000.0,
    1.0 / 74724249600.0,
    -3617.0 / 10670622842880000.0,
    43867.0 / 5109094217170944000.0,
    -174611.0 / 802857662698291200000.0,
];

/// Terms below this fraction of the sum are left out; the sum of the remaining ones is at most ten
/// times as large.
const NEGLIGIBLE: f64 = f64::EPSILON / 1024.0;

/// Returns where the Euler-Maclaurin formula may start for `x^-s`.
///
/// Its terms are about `(s + 2j)^(2j-1) / (2 pi x)^(2j-1)`; from `max(16, 2|s|)` on, ten of them
/// leave less than 1e-16 of the sum.
pub(crate) fn asymptotic_from(s: f64) -> f64 {
    (2.0 * s.abs()).ceil().max(16.0)
}

/// Returns `sum_j B_2j/(2j)! (s)_{2j-1} x^{1-2j}`, the corrections at the end `x` divided by
/// `x^-s`.
pub(crate) fn end_correction(x: f64, s: f64) -> f64 {
    let mut rising = s / x;
    let mut sum = 0.0;
    for (j, coefficient) in EULER_MACLAURIN.iter().enumerate() {
        let term = coefficient * rising;
        sum += term;
        if term.abs() <= NEGLIGIBLE {
            break;
        }
        let next = s + (2 * j + 1) as f64;
        // One quotient at a time, because the squares of large x and s would overflow.
        rising *= (next / x) * ((next + 1.0) / x);
    }
    sum
}

/// Exponents above this would magnify the rounding of a quotient too much.
const LARGE_EXPONENT: f64 = 32.0;

/// Returns `(x / reference)^exponent` for positive `x` and `reference`.
fn ratio_power(x: f64, reference: f64, exponent: f64) -> f64 {
    if exponent.abs() <= LARGE_EXPONENT {
        (x / reference).powf(exponent)
    } else {
        (exponent * ((x - reference) / reference).ln_1p()).exp()
    }
}

/// Returns the integral of `(x / reference)^-s` from `a` to `b`, given the integrand at both ends.
///
/// Near `s = 1` the difference of the two powers would cancel, so there it is written with
/// `exp(t) - 1`.
fn integral(a: f64, b: f64, s: f64, at_a: f64, at_b: f64) -> f64 {
    let log_ratio = ((b - a) / a).ln_1p();
    let t = (1.0 - s) * log_ratio;
    if t == 0.0 {
        at_a * a * log_ratio
    } else if t.abs() <= 1.0 {
        at_a * a * log_ratio * (t.exp_m1() / t)
    } else {
        (b * at_b - a * at_a) / (1.0 - s)
    }
}

/// A sum of powers as `reference^-s * scaled`, so that neither factor overflows before the product
/// does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PowerSum {
    /// The end of the range with the larger term.
    pub(crate) reference: f64,
    /// `sum (k / reference)^-s`, at least 1.
    pub(crate) scaled: f64,
}

/// Returns `sum_{k=first}^{last} k^-s` for integers `1 <= first <= last` held as `f64`, and finite
/// `s`.
///
/// All terms are positive and none is obtained by a difference, so the relative error is a few
/// `f64::EPSILON` for every `s`; about `16 + 2|s|` direct terms at most, and fewer than a hundred
/// for large `|s|`.
pub(crate) fn power_sum(first: f64, last: f64, s: f64) -> PowerSum {
    let reference = if s < 0.0 { last } else { first };
    let start = asymptotic_from(s).max(first);
    let mut sum = CompensatedSum::default();
    if start <= last {
        let (at_start, at_last) =
            (ratio_power(start, reference, -s), ratio_power(last, reference, -s));
        sum.add(integral(start, last, s, at_start, at_last));
        sum.add(at_start * (0.5 + end_correction(start, s)));
        sum.add(at_last * (0.5 - end_correction(last, s)));
    }
    // The terms before `start`, the largest first, so that the loop may stop early. For large `s`
    // they are taken from their distance to the largest, which still counts where 1 is below the
    // spacing of the numbers.
    let direct_last = last.min(start - 1.0);
    let (from, direction) = if s < 0.0 { (direct_last, -1.0) } else { (first, 1.0) };
    let largest = ratio_power(from, reference, -s);
    let mut offset = 0.0;
    while offset <= direct_last - first {
        let term = if s.abs() <= LARGE_EXPONENT {
            ratio_power(from + direction * offset, reference, -s)
        } else {
            largest * (-s * (direction * offset / from).ln_1p()).exp()
        };
        sum.add(term);
        if term <= NEGLIGIBLE * sum.value() {
            break;
        }
        offset += 1.0;
    }
    PowerSum { reference, scaled: sum.value() }
}
