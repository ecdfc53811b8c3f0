use std::f64::consts::{FRAC_PI_6, SQRT_2};

use crate::Domain;

/// Returns an upper bound on the minimum chord of `n_points` points: infinite for one point, sharp
/// for 2, 3, 4, 6 and 12 points of the sphere and 2 of the hemisphere.
///
/// ```text
/// chord^2 <= 4 - 1/sin^2(pi N / (6 (N - 2)))        N >= 3
/// ```
///
/// On the hemisphere the bound is that of the 2 N points and antipodes, and `sqrt(2)`.
///
/// Source: Fejes Toth 1943, Jber. Deutsch. Math.-Verein. 53, 66.
pub(crate) fn greatest_chord(n_points: usize, domain: Domain) -> f64 {
    match domain {
        _ if n_points < 2 => f64::INFINITY,
        Domain::Sphere => fejes_toth(n_points),
        Domain::Hemisphere => fejes_toth(n_points.saturating_mul(2)).min(SQRT_2),
    }
}

fn fejes_toth(n_points: usize) -> f64 {
    if n_points < 3 {
        return 2.0;
    }
    let n = n_points as f64;
    // With a = pi/6 + b, 4 - 1/sin^2 a = (4 sin^2 a - 1)/sin^2 a = 4 sin(b) sin(a + pi/6)/sin^2 a,
    // which avoids cancellation for large N.
    let b = FRAC_PI_6 * 2.0 / (n - 2.0);
    let a = FRAC_PI_6 + b;
    (4.0 * b.sin() * (a + FRAC_PI_6).sin()).sqrt() / a.sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangle, the tetrahedron, the octahedron, the icosahedron; hexagons of large N.
    #[test]
    fn regular_sets_reach_the_bound() {
        let icosahedron = (2.0 - 2.0 / 5_f64.sqrt()).sqrt();
        let expected =
            [(3, 3_f64.sqrt()), (4, (8.0 / 3_f64).sqrt()), (6, SQRT_2), (12, icosahedron)];
        for (n, chord) in expected {
            let got = greatest_chord(n, Domain::Sphere);
            // The roundings of two sines, a root and a quotient.
            assert!((got - chord).abs() < 8.0 * f64::EPSILON, "{n}: {got} against {chord}");
        }
        // The area of a hexagon of inradius r/2 is (sqrt(3)/2) r^2.
        let n = 1e9;
        let hexagons = (8.0 * std::f64::consts::PI / (3_f64.sqrt() * n)).sqrt();
        let got = greatest_chord(1_000_000_000, Domain::Sphere);
        assert!((got / hexagons - 1.0).abs() < 1e-8, "{got} against {hexagons}");
    }

    #[test]
    fn one_point_has_no_bound_and_two_antipodal_pairs_are_at_most_perpendicular() {
        assert!(greatest_chord(1, Domain::Hemisphere).is_infinite());
        assert!((greatest_chord(2, Domain::Sphere) - 2.0).abs() < f64::EPSILON);
        assert!((greatest_chord(2, Domain::Hemisphere) - SQRT_2).abs() < f64::EPSILON);
    }
}
