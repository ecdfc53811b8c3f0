use std::f64::consts::PI;

use super::turns::cis_turns;

/// Replaces `out`, of at least two numbers, by the spherical Bessel functions `j_n(2 pi t)`, n = 0,
/// 1, ..., for t >= 1e-13.
///
/// The recurrence runs upwards where it is stable, for arguments beyond the last order; below, it
/// runs downwards from an order where the functions are negligible (Miller's algorithm), scaled by
/// the first or the second.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at most the number of functions and some more"
)]
pub(super) fn spherical_bessel(t: f64, out: &mut [f64]) {
    let x = 2.0 * PI * t;
    let wave = cis_turns(t);
    let zeroth = wave.im / x;
    let first = (zeroth - wave.re) / x;
    let len = out.len();
    if x > len as f64 {
        (out[0], out[1]) = (zeroth, first);
        for n in 1..len - 1 {
            out[n + 1] = (2 * n + 1) as f64 / x * out[n] - out[n - 1];
        }
        return;
    }
    // Beyond the argument j_n falls faster than geometrically, over a range of orders that grows as
    // the cube root of the argument; from this order on it is below 1e-30.
    let start = (x + 24.0 + 10.0 * x.cbrt()) as usize;
    let (mut above, mut j) = (0.0, 1e-280);
    out.fill(0.0);
    for n in (0..start).rev() {
        // Here j is j_{n + 1} and above j_{n + 2}, with a common factor.
        (above, j) = (j, (2 * n + 3) as f64 / x * j - above);
        if n < len {
            out[n] = j;
        }
        if j.abs() > 1e250 {
            above *= 1e-250;
            j *= 1e-250;
            out.iter_mut().skip(n).for_each(|value| *value *= 1e-250);
        }
    }
    // At least one of j_0 and j_1 is not near a zero; for small arguments j_1 would cancel.
    let scale =
        if x < 1.0 || zeroth.abs() >= first.abs() { zeroth / out[0] } else { first / out[1] };
    out.iter_mut().for_each(|value| *value *= scale);
}

#[cfg(test)]
mod tests {
    use super::spherical_bessel;

    /// The first two are `sin x/x` and `sin x/x^2 - cos x/x`, with series for small x; all orders obey
    /// `sum_n (2n+1) j_n^2 = 1`.
    #[test]
    fn spherical_bessel_functions_have_closed_forms() {
        for len in [2, 48, 300] {
            for x in [1e-12f64, 1e-3, 0.7, 3.2, 31.4, 47.9, 48.1, 299.0, 301.0, 1e4] {
                let mut j = vec![f64::NAN; len];
                spherical_bessel(x / std::f64::consts::TAU, &mut j);
                let (sin, cos) = x.sin_cos();
                let closed = [sin / x, (sin / x - cos) / x];
                let series = [1.0 - x * x / 6.0, x / 3.0 - x.powi(3) / 30.0];
                let expected = if x < 0.01 { series } else { closed };
                for (n, expected) in expected.into_iter().enumerate() {
                    let error = (j[n] - expected).abs();
                    assert!(error < 1e-13 * (1.0 + x) / x.max(1.0), "{len}, j_{n}({x}): {}", j[n]);
                }
                if len > 48 && x < 250.0 {
                    let sum: f64 =
                        j.iter().enumerate().map(|(n, j)| (2 * n + 1) as f64 * j * j).sum();
                    assert!((sum - 1.0).abs() < 1e-13, "{x}: {sum}");
                }
            }
        }
    }
}
