//! The frequencies at which N points of the square can have zero power: vanishing coefficients
//! against degrees of freedom.

use crate::optimization::spectral_control::MAX_SHARE;

/// Returns `2N - 2`: the degrees of freedom of N points modulo shifts.
pub(super) fn degrees_of_freedom(n_points: usize) -> f64 {
    2.0 * (n_points as f64 - 1.0)
}

/// Returns the number of frequencies k other than 0 with `|k|^2 <= square`, the number of real
/// coefficients that must vanish: two for each pair of k and -k.
pub(super) fn frequencies_within(square: u64) -> f64 {
    let last = square.isqrt();
    // For every k1 from 1, k2 from -r to r, and the same for -k1; for k1 = 0, k2 without 0.
    let column = |k1: u64| 2.0 * (square - k1 * k1).isqrt() as f64 + 1.0;
    2.0 * (1..=last).map(column).sum::<f64>() + 2.0 * last as f64
}

/// Returns the largest `|k|^2 <= alpha^2 N`.
///
/// A product within rounding of an integer counts as that integer.
pub(super) fn square_within(alpha: f64, n_points: usize) -> u64 {
    let bound = alpha * alpha * n_points as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "alpha is checked to be small and not negative"
    )]
    let square = (bound * (1.0 + 8.0 * f64::EPSILON)) as u64;
    square
}

/// Returns the largest `|k|^2` up to which N points can have zero power.
pub(super) fn max_empty_square(n_points: usize) -> u64 {
    let max = MAX_SHARE * degrees_of_freedom(n_points);
    // A disk of radius r holds pi r^2 frequencies to within some multiples of r.
    let (mut low, mut high) = (0, n_points as u64 + 4);
    while high - low > 1 {
        let middle = u64::midpoint(low, high);
        if frequencies_within(middle) <= max {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Returns the largest alpha, rounded down to six digits, for which every frequency can have zero
/// power.
pub(super) fn max_alpha(n_points: usize) -> f64 {
    let limit = ((max_empty_square(n_points) + 1) as f64 / n_points as f64).sqrt();
    // The limit itself belongs to the next frequency, so alpha must lie below it.
    ((limit * 1e6).ceil() - 1.0) / 1e6
}

#[cfg(test)]
mod tests {
    use super::{frequencies_within, max_alpha, max_empty_square, square_within};

    #[test]
    fn frequencies_are_counted_one_by_one() {
        for square in 0..200_u64 {
            let k = -15..=15_i64;
            let all = k.clone().flat_map(|k1| k.clone().map(move |k2| k1 * k1 + k2 * k2));
            let count = all.filter(|&s| s > 0 && s.unsigned_abs() <= square).count();
            assert!((frequencies_within(square) - count as f64).abs() < 0.5, "{square}");
        }
    }

    /// `|k| <= (a/100) sqrt(N)` is `10^4 |k|^2 <= a^2 N` in integers.
    #[test]
    fn squares_within_alpha_match_integer_arithmetic() {
        for hundredths in 0..=80_u32 {
            for n in (1..400).chain([2_114, 10_000, 1_000_000, 100_000_000]) {
                let expected = u64::from(hundredths).pow(2) * n as u64 / 10_000;
                let got = square_within(f64::from(hundredths) / 100.0, n);
                assert_eq!(got, expected, "alpha {hundredths}/100, N = {n}");
            }
        }
    }

    #[test]
    fn the_largest_alpha_is_the_last_that_works() {
        for n in (1..600).chain([1_000, 100_000]) {
            let (alpha, max) = (max_alpha(n), max_empty_square(n));
            assert!(square_within(alpha, n) == max, "N = {n}: {alpha}");
            assert!(square_within(alpha + 2e-6, n) > max, "N = {n}: {alpha}");
            // Up to sqrt(N/pi) there are about as many frequencies as points.
            assert!(n < 4 || max >= square_within(std::f64::consts::PI.sqrt().recip(), n), "{n}");
        }
        assert_eq!([1, 2, 3, 4].map(max_empty_square), [0, 0, 0, 1]);
    }
}
