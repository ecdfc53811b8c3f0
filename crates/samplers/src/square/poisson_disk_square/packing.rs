use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// `2/sqrt(3)`: N points of a hexagonal lattice of unit density are the square root of this apart.
const HEXAGONAL: f64 = 1.154_700_538_379_251_5;

/// Returns an upper bound on the minimum distance of `n_points` points of the unit square: infinite
/// for one point, sharp for two.
///
/// ```text
/// N <= (2/sqrt 3)/r^2              opposite sides joined (Thue 1910)
/// N <= (2/sqrt 3)/r^2 + 2/r + 1    otherwise (Oler 1961, doi:10.1007/BF02559535)
/// ```
pub(crate) fn greatest_distance(n_points: usize, is_wrapped: bool) -> f64 {
    let n = n_points as f64;
    if n_points < 2 {
        f64::INFINITY
    } else if is_wrapped {
        (HEXAGONAL / n).sqrt().min(FRAC_1_SQRT_2)
    } else {
        // The positive solution of (2/sqrt 3) x^2 + 2 x + 1 - N = 0 for x = 1/r, free of
        // cancellation.
        let root = (1.0 + HEXAGONAL * (n - 1.0)).sqrt();
        ((1.0 + root) / (n - 1.0)).min(SQRT_2)
    }
}

#[cfg(test)]
mod tests {
    use super::{SQRT_2, greatest_distance};

    /// The maximum minimum distances of 2 to 9 points in a square are known (Schaer 1965, Melissen
    /// 1993); joined sides can only make points nearer to each other.
    #[test]
    fn no_known_packing_exceeds_the_bound() {
        let known = [
            (2, SQRT_2),
            (3, 6.0_f64.sqrt() - SQRT_2),
            (4, 1.0),
            (5, 0.5 * SQRT_2),
            (6, 13.0_f64.sqrt() / 6.0),
            (7, 4.0 - 2.0 * 3.0_f64.sqrt()),
            (8, 0.5 * (6.0_f64.sqrt() - SQRT_2)),
            (9, 0.5),
        ];
        for (n, distance) in known {
            let bound = greatest_distance(n, false);
            assert!((distance..1.4 * distance).contains(&bound), "{n}: {bound} for {distance}");
            assert!(greatest_distance(n, true) < bound, "{n}");
        }
        // Two points at (0, 0) and (1/2, 1/2).
        assert!((greatest_distance(2, true) - 0.5_f64.sqrt()).abs() < f64::EPSILON);
        assert!(
            greatest_distance(1, true).is_infinite() && greatest_distance(1, false).is_infinite()
        );
        // Boundaries matter little for many points.
        let ratio = greatest_distance(1_000_000, false) / greatest_distance(1_000_000, true);
        assert!((1.0..1.002).contains(&ratio), "{ratio}");
    }
}
