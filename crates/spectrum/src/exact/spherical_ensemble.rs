//! The spectrum of the spherical ensemble.

/// Returns the power of degrees 0 to `lmax` of the spherical ensemble of `n_points` points; the
/// entry of degree 0 is 0 instead of N.
///
/// ```text
/// P(l) = 1 - q(l),   q(l) = prod_{k=1}^{l} (N - k)/(N + k)
/// ```
///
/// by the addition theorem from the pair density `1 - ((1 + cos gamma)/2)^{N-1}` (Krishnapur 2009;
/// Alishahi and Zamani 2015). Since `P(l) = P(l-1) + q(l-1) 2l/(N + l)`, no digits cancel.
pub(super) fn power(n_points: usize, lmax: usize) -> Vec<f64> {
    let n = n_points as f64;
    let (mut power, mut rest) = (0.0, 1.0);
    let next = |l: usize| {
        let l = l as f64;
        power += rest * 2.0 * l / (n + l);
        // From degree N on nothing is left.
        rest *= (n - l).max(0.0) / (n + l);
        power
    };
    std::iter::once(0.0).chain((1..=lmax).map(next)).collect()
}

#[cfg(test)]
mod tests {
    use super::power;

    /// Reference: the product as it stands. Each factor has an error of some units in the last
    /// place.
    #[test]
    fn power_is_one_less_the_product() {
        for n in [1_usize, 2, 3, 10, 100, 1000] {
            let got = power(n, 2 * n + 5);
            let mut product = 1.0;
            for (l, p) in got.iter().enumerate().skip(1) {
                product *= (n as f64 - l as f64).max(0.0) / (n + l) as f64;
                let off = p - (1.0 - product);
                assert!(off.abs() < 4.0 * (l + 1) as f64 * f64::EPSILON, "{n} {l}: {off:e}");
            }
        }
    }

    /// `P(1) = 2/(N + 1)`, `P(2) = 6N/((N + 1)(N + 2))`, also where they are far below the rounding
    /// of 1.
    #[test]
    fn low_degrees_of_many_points_keep_their_relative_accuracy() {
        for n in [1_usize, 2, 7, 1 << 20, 1 << 52, 1 << 62] {
            let x = n as f64;
            let got = power(n, 2);
            for (p, expected) in
                [(got[1], 2.0 / (x + 1.0)), (got[2], 6.0 * (x / (x + 1.0)) / (x + 2.0))]
            {
                assert!((p / expected - 1.0).abs() < 8.0 * f64::EPSILON, "{n}: {p} {expected}");
            }
        }
    }

    /// Reference: the integral of the pair density, `P(l) = 1 - (N/2) int ((1+t)/2)^{N-1} P_l(t) dt`,
    /// by the midpoint rule with an error of 1e-6.
    #[test]
    fn power_is_that_of_the_pair_density() {
        const STEPS: u32 = 20_000;
        for n in [2_usize, 5, 30] {
            let got = power(n, 4);
            let mut sums = [0.0; 5];
            for k in 0..STEPS {
                let t = (f64::from(k) + 0.5) / f64::from(STEPS) * 2.0 - 1.0;
                let weight = ((1.0 + t) / 2.0).powf(n as f64 - 1.0) * n as f64 / f64::from(STEPS);
                let legendre = [
                    1.0,
                    t,
                    (3.0 * t * t - 1.0) / 2.0,
                    (5.0 * t * t - 3.0) * t / 2.0,
                    ((35.0 * t * t - 30.0) * t * t + 3.0) / 8.0,
                ];
                for (sum, p) in sums.iter_mut().zip(legendre) {
                    *sum += weight * p;
                }
            }
            for l in 1..=4 {
                assert!((got[l] - (1.0 - sums[l])).abs() < 1e-5, "{n} {l}: {} {}", got[l], sums[l]);
            }
        }
    }
}
