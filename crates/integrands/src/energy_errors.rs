use sphvar_sh::{Bands, ByParity};

/// The errors of an [`Energy`](crate::Energy) that is estimated: of the energy of every band and of
/// the totals over all bands from 1, by parity.
///
/// How the errors of several bands combine is one of two models:
///
/// - **Independent** standard errors ([`Energy::with_stderr`](crate::Energy::with_stderr)), as from
///   noise of values. The bands beyond the last known one are independent of the others too, so the
///   variance of a total is the sum of those of its bands.
/// - **Bounds** ([`Energy::with_error_bounds`](crate::Energy::with_error_bounds)), as from a
///   quadrature, whose errors in different bands may have the same sign and add up.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyErrors {
    per_band: Vec<f64>,
    /// Whether a band is even, from band 0.
    parities: Vec<bool>,
    centred: ByParity,
    independent: bool,
}

impl EnergyErrors {
    pub(crate) fn new(
        bands: &impl Bands,
        per_band: Vec<f64>,
        centred: ByParity,
        independent: bool,
    ) -> Self {
        let parities = (0..per_band.len()).map(|band| bands.is_even(band)).collect();
        Self { per_band, parities, centred, independent }
    }

    /// Returns the error of the energy of every band from 0.
    #[must_use]
    pub fn per_band(&self) -> &[f64] {
        &self.per_band
    }

    /// Returns the errors of the totals of the even bands from 1 and of the odd bands.
    #[must_use]
    pub fn centred(&self) -> ByParity {
        self.centred
    }

    /// Returns whether the errors of different bands are independent; otherwise they may add up.
    #[must_use]
    pub fn are_independent(&self) -> bool {
        self.independent
    }

    /// Returns the error of `sum_{l >= 1} E(l) P(l)` with the factors `power` of the bands from 0
    /// to their last, inclusive, and `beyond` of all higher bands by parity.
    ///
    /// The sum is `S = sum_{l = 1..L} E(l) P(l) + sum_p T_p (C_p - sum_{l <= L, parity p} E(l))`
    /// with the totals C and the factors T of the higher bands. Independent errors e of the E and
    /// c of the C, which contain those of the E, add up as
    ///
    /// ```text
    /// sum_{l = 1..L} (e(l) P(l))^2 + sum_p T_p^2 (c_p^2 - sum_{l <= L, parity p} e(l)^2)
    /// ```
    ///
    /// where a negative difference counts as 0. Bounds add up as the derivatives of S, in which
    /// an energy that moves from a band to higher ones of the same factor cancels:
    ///
    /// ```text
    /// sum_{l = 1..L} e(l) |P(l) - T_p(l)| + sum_p T_p c_p
    /// ```
    #[must_use]
    pub fn of_sum(&self, power: &[f64], beyond: ByParity) -> f64 {
        let known = self.per_band.iter().zip(&self.parities).zip(power).skip(1);
        // Relative to the largest error, so that no square overflows or underflows.
        let totals = [self.centred.even, self.centred.odd];
        let errors = self.per_band.iter().skip(1).chain(&totals).copied();
        let largest = errors.fold(0.0, |max, e| if e <= max || f64::is_nan(max) { max } else { e });
        if largest == 0.0 {
            return 0.0;
        }
        let (mut sum, mut shares) = (0.0, ByParity::both(0.0));
        for ((error, &even), power) in known {
            let error = error / largest;
            let limit = if even { beyond.even } else { beyond.odd };
            if self.independent {
                sum += (error * power).powi(2);
                *shares.at_mut(even) += error * error;
            } else {
                sum += error * (power - limit).abs();
            }
        }
        let totals = self.centred.map(|c| c / largest);
        if !self.independent {
            return largest * (sum + beyond.map(f64::abs).dot(totals));
        }
        let rest = totals.zip(shares).map(|(c, share)| {
            let rest = c * c - share;
            if rest < 0.0 { 0.0 } else { rest }
        });
        largest * (sum + beyond.map(|t| t * t).dot(rest)).sqrt()
    }

    /// Returns the errors of the first bands.
    pub(crate) fn truncated(&self, n_bands: usize) -> Self {
        Self {
            per_band: self.per_band[..n_bands].to_vec(),
            parities: self.parities[..n_bands].to_vec(),
            ..*self
        }
    }

    /// Returns the errors of the energies times a positive factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            per_band: self.per_band.iter().map(|e| factor * e).collect(),
            centred: self.centred.map(|e| factor * e),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use sphvar_sh::{ByParity, Domain};

    use crate::Energy;

    const CENTRED: ByParity = ByParity { even: 3.0, odd: 5.0 };

    fn energy() -> Energy {
        Energy::new(Domain::Sphere, vec![9.0, 4.0, 2.0, 0.5], CENTRED)
    }

    /// The variance of the sum over random energies, of which all bands are independent: three
    /// known ones and one beyond of each parity.
    #[test]
    fn independent_errors_are_those_of_random_energies() {
        let (per_band, rest) = ([7.0, 0.3, 0.2, 0.1], [0.4, 0.05]);
        let square = |x: &[f64]| x.iter().map(|e| e * e).sum::<f64>().sqrt();
        let centred = ByParity { even: square(&[0.2, rest[0]]), odd: square(&[0.3, 0.1, rest[1]]) };
        let errors = energy().with_stderr(per_band.to_vec(), centred);
        let tail = ByParity { even: 2.0, odd: 0.5 };
        for power in [&[100.0, 0.25, 0.5, 3.0][..], &[100.0, 0.25], &[]] {
            // Bands without a factor of their own have that of higher ones.
            let factor = |l: usize| power.get(l).copied().unwrap_or(*tail.of(l));
            let terms: Vec<f64> = (1..4).map(|l| per_band[l] * factor(l)).collect();
            let expected = square(&[square(&terms), rest[0] * tail.even, rest[1] * tail.odd]);
            let got = errors.errors().unwrap().of_sum(power, tail);
            assert!((got / expected - 1.0).abs() < 1e-14, "{power:?}: {got} and {expected}");
        }
    }

    /// The largest change of the sum while every energy and total moves by at most its bound.
    #[test]
    fn bounds_are_reached_by_the_worst_signs() {
        let (per_band, centred) = ([7.0, 0.3, 0.2, 0.1], ByParity { even: 0.7, odd: 0.6 });
        let bounded = energy().with_error_bounds(per_band.to_vec(), centred);
        let (power, tail) = ([100.0, 0.25, 2.5, 3.0], ByParity { even: 2.0, odd: 0.5 });
        let sum = |signs: usize| {
            let sign = |bit: usize| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let moved: Vec<f64> = (0..4).map(|l| sign(l) * per_band[l]).collect();
            let totals = ByParity { even: sign(4) * centred.even, odd: sign(5) * centred.odd };
            let known: f64 = (1..4).map(|l| moved[l] * (power[l] - tail.of(l))).sum();
            known + totals.dot(tail)
        };
        let worst = (0..64).map(sum).fold(0.0, f64::max);
        let got = bounded.errors().unwrap().of_sum(&power, tail);
        assert!((got / worst - 1.0).abs() < 1e-14, "{got} and {worst}");
        // Energy that moves between bands of equal factors changes nothing.
        let equal = bounded.errors().unwrap().of_sum(&[1.0; 4], ByParity::both(1.0));
        assert!((equal - centred.sum()).abs() < 1e-14, "{equal}");
    }

    #[test]
    fn sizes_at_the_limits_neither_overflow_nor_vanish() {
        for scale in [1e-302, 1.0, 1e302] {
            let per_band = vec![scale; 4];
            let errors = energy().with_stderr(per_band.clone(), ByParity::both(2.0 * scale));
            let got = errors.errors().unwrap().of_sum(&[1.0; 4], ByParity::both(1.0));
            assert!((got / (scale * 8f64.sqrt()) - 1.0).abs() < 1e-14, "{scale}: {got}");
            assert_eq!(errors.per_band_stderr(), Some(&per_band[..]));
        }
        let none = energy().with_stderr(vec![0.0; 4], ByParity::both(0.0));
        assert!(none.errors().unwrap().of_sum(&[1.0; 4], ByParity::both(1.0)) <= 0.0);
        let unknown = energy().with_stderr(vec![0.0, 1.0, f64::NAN, 0.0], CENTRED);
        assert!(unknown.errors().unwrap().of_sum(&[1.0; 4], ByParity::both(1.0)).is_nan());
    }
}
