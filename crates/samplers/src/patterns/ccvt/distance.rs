//! Squared geodesic distances from squared chords.

const N_COEFFICIENTS: usize = 20;

/// `a_n = 2 / (n^2 binom(2n, n))` of `d^2 = sum_{n >= 1} a_n c^n`, where c is the squared chord of
/// the geodesic distance d: the square of the arcsine's series (Borwein and Chamberland 2007).
const COEFFICIENTS: [f64; N_COEFFICIENTS] = {
    let mut a = [1.0; N_COEFFICIENTS];
    let mut n = 1;
    while n < N_COEFFICIENTS {
        // a_(n+1)/a_n = n^2 / ((2n+1) (2n+2)).
        let k = n as f64;
        a[n] = a[n - 1] * k * k / ((2.0 * k + 1.0) * (2.0 * k + 2.0));
        n += 1;
    }
    a
};

/// The number of terms of the series that a bound on the squared chord requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    Four,
    Six,
    Ten,
    Twenty,
    Arcsine,
}

impl Precision {
    /// Returns the least expensive evaluation whose relative error is below 1e-13 up to squared
    /// chord `c`.
    ///
    /// The first omitted term is `a_(n+1) c^n` relative to d^2, and each further term is smaller by
    /// c/4; for the derivative it is n + 1 times larger.
    pub(super) fn up_to(c: f64) -> Self {
        if c < 2.8e-3 {
            Self::Four
        } else if c < 0.033 {
            Self::Six
        } else if c < 0.22 {
            Self::Ten
        } else if c < 0.95 {
            Self::Twenty
        } else {
            Self::Arcsine
        }
    }
}

/// Returns d^2 from `TERMS` terms of the series, or from the arcsine if `TERMS` is 0.
#[inline(always)]
pub(super) fn squared_angle<const TERMS: usize>(c: f64) -> f64 {
    if TERMS == 0 {
        let d = 2.0 * (0.5 * c.max(0.0).sqrt()).min(1.0).asin();
        return d * d;
    }
    let mut sum = COEFFICIENTS[TERMS - 1];
    for n in (0..TERMS - 1).rev() {
        sum = sum * c + COEFFICIENTS[n];
    }
    sum * c
}

/// Returns `d/sin d`, the derivative of d^2 with respect to c: the ratio of the length of the
/// tangent vector to a point to the length of the point's projection.
#[inline(always)]
pub(super) fn stretch<const TERMS: usize>(c: f64) -> f64 {
    if TERMS == 0 {
        let half = (0.5 * c.max(0.0).sqrt()).min(1.0);
        let sin = 2.0 * half * ((1.0 - half) * (1.0 + half)).sqrt();
        // At the antipode the direction is undefined; the contribution to the sum is 0 there, and
        // finite.
        return if half < 1e-4 { 1.0 + c / 6.0 } else { 2.0 * half.asin() / sin.max(1e-9) };
    }
    let mut sum = TERMS as f64 * COEFFICIENTS[TERMS - 1];
    for n in (0..TERMS - 1).rev() {
        sum = sum * c + (n + 1) as f64 * COEFFICIENTS[n];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{COEFFICIENTS, Precision, squared_angle, stretch};

    #[test]
    fn the_coefficients_match_the_squared_arcsine() {
        for (n, inverse) in [1.0, 12.0, 90.0, 560.0, 3150.0, 16632.0].into_iter().enumerate() {
            let product = COEFFICIENTS[n] * inverse;
            // One rounding per step of the recurrence, and one here.
            assert!((product - 1.0).abs() <= 6.0 * f64::EPSILON, "a_{} is off: {product}", n + 1);
        }
    }

    /// Returns d^2 and d/sin d with the requested precision.
    fn values(precision: Precision, c: f64) -> [f64; 2] {
        match precision {
            Precision::Four => [squared_angle::<4>(c), stretch::<4>(c)],
            Precision::Six => [squared_angle::<6>(c), stretch::<6>(c)],
            Precision::Ten => [squared_angle::<10>(c), stretch::<10>(c)],
            Precision::Twenty => [squared_angle::<20>(c), stretch::<20>(c)],
            Precision::Arcsine => [squared_angle::<0>(c), stretch::<0>(c)],
        }
    }

    #[test]
    fn every_precision_meets_its_error_bound_up_to_its_limit() {
        let mut seen = Vec::new();
        for k in 1..4000u32 {
            let d = f64::from(k) * 1e-3 * 0.78;
            let c = (2.0 * (0.5 * d).sin()).powi(2);
            let precision = Precision::up_to(c);
            if !seen.contains(&precision) {
                seen.push(precision);
            }
            let [square, ratio] = values(precision, c);
            // Near 1 the arcsine amplifies the rounding of c by d/(4 - c).
            let rounding = 8.0 * f64::EPSILON * (1.0 + d * d / (4.0 - c));
            let off = (square / (d * d) - 1.0).abs();
            assert!(off < 1e-13 + rounding, "d = {d}, {precision:?}: d^2 off by {off}");
            let off = (ratio * d.sin() / d - 1.0).abs();
            let rounding = rounding * (1.0 + d / d.sin());
            assert!(off < 2e-12 + rounding, "d = {d}, {precision:?}: d/sin d off by {off}");
        }
        assert_eq!(seen.len(), 5, "{seen:?}");
    }

    #[test]
    fn coincidence_and_antipode_have_finite_values() {
        for precision in [Precision::Four, Precision::Twenty, Precision::Arcsine] {
            let bits = values(precision, 0.0).map(f64::to_bits);
            assert_eq!(bits, [0.0, 1.0].map(f64::to_bits), "{precision:?}");
        }
        // Rounding can take 2 - 2 cos d out of [0, 4].
        for c in [-4.0 * f64::EPSILON, 4.0, 4.0 + 4.0 * f64::EPSILON] {
            let [square, ratio] = values(Precision::Arcsine, c);
            let d = if c > 1.0 { std::f64::consts::PI } else { 0.0 };
            assert!((square - d * d).abs() < 1e-6, "c = {c}: {square}");
            assert!(ratio.is_finite(), "c = {c}: {ratio}");
        }
    }
}
