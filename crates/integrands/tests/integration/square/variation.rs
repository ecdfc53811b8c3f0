use std::sync::LazyLock;

use proptest::prelude::*;

use super::cases::{Case, cases};

/// Returns the star discrepancy from its definition: the largest difference between the share of the
/// points in [0, a) x [0, b) or in its closure and a b, over all a and b of coordinates or 1.
fn star_discrepancy(points: &[[f64; 2]]) -> f64 {
    let ends = |axis: usize| points.iter().map(move |p| p[axis]).chain([1.0]);
    let share = |is_inside: &dyn Fn(&[f64; 2]) -> bool| {
        points.iter().filter(|point| is_inside(point)).count() as f64 / points.len() as f64
    };
    let mut largest = 0.0f64;
    for a in ends(0) {
        for b in ends(1) {
            let open = share(&|&[u, v]| u < a && v < b);
            let closed = share(&|&[u, v]| u <= a && v <= b);
            largest = largest.max(a * b - open).max(closed - a * b);
        }
    }
    largest
}

/// The sum of mixed differences over a grid and of differences along the far sides is at most the
/// variation, and tends to it.
#[test]
fn variations_are_limits_of_sums_of_differences() {
    const N: usize = 420;
    for case in cases() {
        let Some(variation) = case.integrand.variation() else { continue };
        // The last nodes are inside, for the limits of functions with jumps across the sides.
        let at = |i: usize| (i as f64 / N as f64).min(1.0 - 1e-12);
        let value = |i: usize, j: usize| case.integrand.eval([at(j), at(i)]);
        let rows: Vec<Vec<f64>> = (0..=N).map(|i| (0..=N).map(|j| value(i, j)).collect()).collect();
        let mut sum = 0.0;
        for i in 0..N {
            sum += (rows[i + 1][N] - rows[i][N]).abs() + (rows[N][i + 1] - rows[N][i]).abs();
            for j in 0..N {
                sum += (rows[i][j] - rows[i + 1][j] - rows[i][j + 1] + rows[i + 1][j + 1]).abs();
            }
        }
        assert!(sum <= variation * (1.0 + 1e-9), "{}: {sum}, {variation}", case.name);
        assert!(sum >= 0.985 * variation, "{}: {sum}, {variation}", case.name);
    }
}

/// An edge along a side and a constant have finite variations.
#[test]
fn edges_along_the_sides_have_a_variation() {
    let of = |degrees, offset| {
        sphvar_integrands::SquareIntegrand::variation(
            &sphvar_integrands::HalfPlane::new(degrees, offset).unwrap(),
        )
    };
    assert_eq!((of(90.0, 0.2), of(180.0, -0.1)), (Some(1.0), Some(1.0)));
    assert_eq!((of(1e-9, 0.2), of(30.0, -1.0)), (None, Some(0.0)));
}

static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The inequality of Koksma and Hlawka.
    #[test]
    fn errors_are_within_discrepancy_times_variation(
        points in prop::collection::vec(prop::array::uniform2(0.0..1.0f64), 1..24),
        scale in 0.0..1.0f64,
    ) {
        // Points near the origin, too, for large discrepancies.
        let points: Vec<[f64; 2]> = points.iter().map(|p| p.map(|x| x * (1.0 - 0.9 * scale))).collect();
        let discrepancy = star_discrepancy(&points);
        for case in &*CASES {
            let Some(variation) = case.integrand.variation() else { continue };
            let sum: f64 = points.iter().map(|p| case.integrand.eval(*p)).sum();
            let error = (sum / points.len() as f64 - case.integrand.exact().unwrap()).abs();
            let bound = discrepancy * variation;
            prop_assert!(error <= bound * (1.0 + 1e-12) + 1e-14, "{}: {error} {bound}", case.name);
        }
    }
}
