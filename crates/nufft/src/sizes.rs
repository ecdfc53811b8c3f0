//! Lengths of Fourier transforms.

/// Returns the multiple of 4 between `min` and `slack * min` with the min expensive transform; if
/// none has prime factors up to 7 only, the next larger one that does.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a grid size")]
pub fn good_size(min: f64, slack: f64) -> usize {
    let min = (min as usize).next_multiple_of(4);
    let max = (min as f64 * slack) as usize;
    let cost = |n: usize| transform_cost(n).unwrap_or(f64::INFINITY);
    let candidates = (min..=max).step_by(4).filter(|&n| transform_cost(n).is_some());
    let best = candidates.min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
    best.or_else(|| (min..).step_by(4).find(|&n| transform_cost(n).is_some())).unwrap_or(min)
}

/// Returns the relative cost of a transform of length n; `None` if a prime factor is above 7.
///
/// The costs of radices relative to 2 were measured with rustfft 6.4 on AVX2, lengths 512 to 6144.
fn transform_cost(n: usize) -> Option<f64> {
    let (mut rest, mut per_number) = (n, 0.0);
    for (prime, cost) in [(2, 1.0), (3, 1.7), (5, 2.6), (7, 4.5)] {
        while rest.is_multiple_of(prime) {
            rest /= prime;
            per_number += cost;
        }
    }
    (rest == 1).then_some(n as f64 * per_number)
}
