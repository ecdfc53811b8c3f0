//! Lengths of Fourier transforms.

/// The size from `least` to a little more, a multiple of 4, that takes least time to transform,
/// where `slack` says how much more.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a grid size")]
pub fn good_size(least: f64, slack: f64) -> usize {
    let least = (least as usize).next_multiple_of(4);
    let most = (least as f64 * slack) as usize;
    let cost = |n: usize| transform_cost(n).unwrap_or(f64::INFINITY);
    let in_reach = (least..=most).step_by(4).filter(|&n| transform_cost(n).is_some());
    let best = in_reach.min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
    best.or_else(|| (least..).step_by(4).find(|&n| transform_cost(n).is_some())).unwrap_or(least)
}

/// The time for a transform of length n, relative to others; none if a prime factor is above 7.
///
/// The cost of radices relative to 2 was measured with rustfft 6.4 on AVX2, lengths 512 to 6144.
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

#[cfg(test)]
mod tests {
    use super::good_size;

    #[test]
    fn sizes_are_smooth_and_near() {
        for least in 4..3000_u32 {
            for slack in [1.0, 1.04, 1.15] {
                let n = good_size(f64::from(least), slack);
                assert!(n >= least as usize && n.is_multiple_of(4), "{least}: {n}");
                let smooth = [2, 3, 5, 7].into_iter().fold(n, |mut rest, p| {
                    while rest.is_multiple_of(p) {
                        rest /= p;
                    }
                    rest
                });
                assert_eq!(smooth, 1, "{least}: {n}");
                // Smooth multiples of 4 are nowhere as far apart as a fifth, from 16 on.
                assert!(n as f64 <= 1.2 * f64::from(least) + 12.0, "{least}: {n}");
            }
        }
    }
}
