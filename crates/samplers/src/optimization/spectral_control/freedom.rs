//! The degrees at which N points can have zero power: vanishing coefficients against degrees of
//! freedom.

use crate::Domain;

/// The largest ratio of vanishing coefficients to degrees of freedom at which descents converge.
pub(crate) const MAX_SHARE: f64 = 0.97;

/// The last degrees of zero power where the count does not determine them: small sets that exist by
/// symmetry although they have more coefficients than degrees of freedom, and designs that the
/// count allows but that are not known (Hardin and Sloane 1996, doi:10.1007/BF02711518).
const EXCEPTIONS: [(Domain, usize, usize); 11] = [
    // Two poles, three points of a great circle, the tetrahedron.
    (Domain::Sphere, 2, 1),
    (Domain::Sphere, 3, 1),
    (Domain::Sphere, 4, 2),
    // Three axes, the four diagonals of a cube.
    (Domain::Hemisphere, 3, 2),
    (Domain::Hemisphere, 4, 2),
    // No 4-design of 15 points, 5-design of 21, 6 of 27, 7 of 35, 8 of 43, 9 of 53.
    (Domain::Sphere, 15, 3),
    (Domain::Sphere, 21, 4),
    (Domain::Sphere, 27, 5),
    (Domain::Sphere, 35, 6),
    (Domain::Sphere, 43, 7),
    (Domain::Sphere, 53, 8),
];

/// Returns `2N - 3`, or 0: the degrees of freedom of N points modulo rotations.
pub(super) fn degrees_of_freedom(n_points: usize) -> f64 {
    (2.0 * n_points as f64 - 3.0).max(0.0)
}

/// Returns the number of coefficients of the domain's degrees from 1 to `last`, inclusive.
pub(super) fn coefficients(last: usize, domain: Domain) -> f64 {
    let l = (last - last % domain.degree_step()) as f64;
    match domain {
        Domain::Sphere => l * (l + 2.0),
        Domain::Hemisphere => 0.5 * l * (l + 3.0),
    }
}

/// Returns the last degree `l <= alpha sqrt(N)` of the domain (2N instead of N on the hemisphere).
///
/// A product within rounding of an integer counts as that integer: 0.29 sqrt(10000) is 29, not
/// 28.999999999999996.
pub(crate) fn degree_within(alpha: f64, n_points: usize, domain: Domain) -> usize {
    let bound = alpha * domain.count_on_sphere(n_points).sqrt();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "alpha is checked to be small and not negative"
    )]
    let degree = (bound * (1.0 + 4.0 * f64::EPSILON)) as usize;
    degree - degree % domain.degree_step()
}

/// Returns the last degree up to which N points can have zero power.
pub(super) fn max_empty_degree(n_points: usize, domain: Domain) -> usize {
    let exception = EXCEPTIONS.iter().find(|set| (set.0, set.1) == (domain, n_points));
    if let Some(&(_, _, last)) = exception {
        return last;
    }
    // Degrees above sqrt(2) sqrt(N) need more degrees of freedom than there are.
    let mut last = degree_within(std::f64::consts::SQRT_2, n_points, domain);
    while coefficients(last, domain) > MAX_SHARE * degrees_of_freedom(n_points) {
        last -= domain.degree_step();
    }
    last
}

/// Returns the largest alpha, rounded down to six digits, for which every degree can have zero
/// power.
pub(super) fn max_alpha(n_points: usize, domain: Domain) -> f64 {
    let first_beyond = max_empty_degree(n_points, domain) + domain.degree_step();
    let limit = first_beyond as f64 / domain.count_on_sphere(n_points).sqrt();
    // The limit itself belongs to the next degree, so alpha must lie below it.
    ((limit * 1e6).ceil() - 1.0) / 1e6
}

#[cfg(test)]
mod tests {
    use super::{Domain, coefficients, degree_within, max_alpha, max_empty_degree};
    use crate::SpectralTarget;

    const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

    #[test]
    fn coefficients_are_those_of_a_target() {
        for domain in DOMAINS {
            for last in 0..60 {
                let target = SpectralTarget::new(vec![0.0; last + 1]).unwrap();
                let (got, expected) = (coefficients(last, domain), target.constraints(domain));
                assert!((got - expected as f64).abs() < 0.5, "{domain} {last}: {got}, {expected}");
            }
        }
    }

    /// `l <= (a/100) sqrt(N)` is `(100 l)^2 <= a^2 N` in integers, which is free of rounding.
    #[test]
    fn degrees_within_alpha_match_integer_arithmetic() {
        for domain in DOMAINS {
            for hundredths in 0..=141_u16 {
                let alpha = f64::from(hundredths) / 100.0;
                for n in (1..400).chain([2_114, 10_000, 40_000, 1_000_000, 100_000_000]) {
                    let density = n * domain.degree_step();
                    let whole = (usize::from(hundredths).pow(2) * density).isqrt() / 100;
                    let expected = whole - whole % domain.degree_step();
                    let got = degree_within(alpha, n, domain);
                    assert_eq!(got, expected, "{domain}, alpha {alpha}, N = {n}");
                }
            }
        }
    }

    /// The numbers of points for which no set has zero power up to sqrt(N): on the sphere 1, 5 and
    /// 9, because neither a 2-design of 5 points nor a 3-design of 9 points exists.
    #[test]
    fn few_numbers_have_no_set_for_an_alpha_of_1() {
        for (domain, expected) in DOMAINS.into_iter().zip([vec![1, 5, 9], vec![2, 8]]) {
            let missing: Vec<usize> = (1..2000)
                .filter(|&n| max_empty_degree(n, domain) < degree_within(1.0, n, domain))
                .collect();
            assert_eq!(missing, expected, "{domain}");
        }
    }

    #[test]
    fn the_largest_alpha_is_the_last_that_works() {
        for domain in DOMAINS {
            for n in (1..600).chain([1_000, 5_252, 100_000, 1_000_000_000, u32::MAX as usize]) {
                let (alpha, max_degree) = (max_alpha(n, domain), max_empty_degree(n, domain));
                assert_eq!(
                    degree_within(alpha, n, domain),
                    max_degree,
                    "{domain}, N = {n}: {alpha}"
                );
                assert!(
                    degree_within(alpha + 2e-6, n, domain) > max_degree,
                    "{domain}, N = {n}: {alpha}"
                );
            }
        }
    }
}
