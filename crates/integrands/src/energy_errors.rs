use sphvar_sh::{Bands, ByParity, TailClasses};

use crate::Energy;

/// The errors of an [`Energy`](crate::Energy) that is estimated: of the energy of every band and of
/// the totals over all bands from 1, by class.
///
/// How the errors of several bands combine is one of two models:
///
/// - **Independent** standard errors ([`Energy::with_stderr`](crate::Energy::with_stderr)), as from
///   noise of values. The bands beyond the last known one are independent of the others too, so the
///   variance of a total is the sum of those of its bands.
/// - **Other estimates** of the same energies
///   ([`Energy::with_estimates`](crate::Energy::with_estimates)), as from coarser quadratures. The
///   error of any sum of energies is the largest deviation of theirs, so that errors of different
///   bands cancel or add up as they do in the estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyErrors<T = ByParity> {
    per_band: Vec<f64>,
    centred: T,
    /// The class of every band from 0.
    classes: Vec<u8>,
    /// Of the other estimates; empty for independent errors.
    deviations: Vec<Deviation<T>>,
}

/// The differences of two estimates of energies.
#[derive(Clone, Debug, PartialEq)]
struct Deviation<T> {
    per_band: Vec<f64>,
    centred: T,
}

impl<T: TailClasses> EnergyErrors<T> {
    pub(crate) fn independent(
        bands: &impl Bands<Tail = T>,
        per_band: Vec<f64>,
        centred: T,
    ) -> Self {
        let classes = classes(bands, per_band.len());
        Self { per_band, centred, classes, deviations: vec![] }
    }

    pub(crate) fn of_estimates<B: Bands<Tail = T>>(
        energy: &Energy<B>,
        others: &[Energy<B>],
    ) -> Self {
        let deviation = |other: &Energy<B>| {
            let pairs = energy.per_band().iter().zip(other.per_band());
            let centred = T::from_fn(|c| other.centred().get(c) - energy.centred().get(c));
            Deviation { per_band: pairs.map(|(a, b)| b - a).collect(), centred }
        };
        let deviations: Vec<_> = others.iter().map(deviation).collect();
        let n_bands = energy.per_band().len();
        let per_band = |l: usize| max_abs(deviations.iter().map(|d| d.per_band[l]));
        Self {
            per_band: (0..n_bands).map(per_band).collect(),
            centred: T::from_fn(|class| max_abs(deviations.iter().map(|d| d.centred.get(class)))),
            classes: classes(energy.bands(), n_bands),
            deviations,
        }
    }

    /// Returns the error of the energy of every band from 0.
    #[must_use]
    pub fn per_band(&self) -> &[f64] {
        &self.per_band
    }

    /// Returns the errors of the totals of the bands from 1 by class.
    #[must_use]
    pub fn centred(&self) -> T {
        self.centred
    }

    /// Returns the error of `sum_{l >= 1} E(l) P(l)` with the factors `power` of the bands from 0
    /// to their last, inclusive, and `beyond` of all higher bands by class.
    ///
    /// With the totals C and the factors T of the higher bands of every class c, the sum is
    ///
    /// ```text
    /// S = sum_{l = 1..L} E(l) (P(l) - T_c(l)) + sum_c T_c C_c
    /// ```
    ///
    /// With other estimates, its error is the largest of their `|S' - S|`. Independent errors e of
    /// the E and f of the C, which contain those of the E, add up as
    ///
    /// ```text
    /// sum_{l = 1..L} (e(l) P(l))^2 + sum_c T_c^2 (f_c^2 - sum_{l <= L, class c} e(l)^2)
    /// ```
    ///
    /// where a negative difference counts as 0.
    #[must_use]
    pub fn of_sum(&self, power: &[f64], beyond: T) -> f64 {
        if self.deviations.is_empty() {
            return self.of_independent(power, beyond);
        }
        let of_estimate = |deviation: &Deviation<T>| {
            let bands = deviation.per_band.iter().zip(&self.classes).zip(power).skip(1);
            let moved = |((d, &class), p): ((&f64, &u8), &f64)| d * (p - beyond.get(class.into()));
            bands.map(moved).sum::<f64>() + beyond.dot(deviation.centred)
        };
        max_abs(self.deviations.iter().map(of_estimate))
    }

    fn of_independent(&self, power: &[f64], beyond: T) -> f64 {
        // Relative to the largest error, so that no square overflows or underflows.
        let totals = (0..T::COUNT).map(|class| self.centred.get(class));
        let largest = max_abs(self.per_band.iter().skip(1).copied().chain(totals));
        if largest == 0.0 {
            return 0.0;
        }
        let (mut sum, mut shares) = (0.0, vec![0.0; T::COUNT]);
        let bands = self.per_band.iter().zip(&self.classes).zip(power).skip(1);
        for ((error, &class), power) in bands {
            let error = error / largest;
            sum += (error * power).powi(2);
            shares[usize::from(class)] += error * error;
        }
        let rest = T::from_fn(|class| {
            let total = self.centred.get(class) / largest;
            let rest = total * total - shares[class];
            if rest < 0.0 { 0.0 } else { rest }
        });
        largest * (sum + beyond.map(|t| t * t).dot(rest)).sqrt()
    }

    /// Replaces the error of band 0, which no sum of energies contains.
    pub(crate) fn set_of_mean(&mut self, error: f64) {
        self.per_band[0] = error;
    }

    /// Returns the errors of the first bands.
    pub(crate) fn truncated(&self, n_bands: usize) -> Self {
        self.mapped(|per_band| per_band[..n_bands].to_vec(), |total| total)
    }

    /// Returns the errors of the energies times a positive factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let scale = |x: f64| factor * x;
        self.mapped(|per_band| per_band.iter().copied().map(scale).collect(), scale)
    }

    fn mapped(&self, bands: impl Fn(&[f64]) -> Vec<f64>, total: impl Fn(f64) -> f64) -> Self {
        let of_deviation = |d: &Deviation<T>| Deviation {
            per_band: bands(&d.per_band),
            centred: d.centred.map(&total),
        };
        let per_band = bands(&self.per_band);
        Self {
            classes: self.classes[..per_band.len()].to_vec(),
            per_band,
            centred: self.centred.map(&total),
            deviations: self.deviations.iter().map(of_deviation).collect(),
        }
    }
}

/// Returns the class of every band from 0; no space has more than a few.
#[expect(clippy::cast_possible_truncation, reason = "classes are small numbers")]
fn classes(bands: &impl Bands, n_bands: usize) -> Vec<u8> {
    (0..n_bands).map(|band| bands.tail_class(band) as u8).collect()
}

/// Returns the largest absolute value, NaN if one is unknown.
fn max_abs(values: impl Iterator<Item = f64>) -> f64 {
    let larger = |max: f64, x: f64| if x.abs() <= max || max.is_nan() { max } else { x.abs() };
    values.fold(0.0, larger)
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

    /// The largest difference of the sums over the estimates.
    #[test]
    fn errors_of_estimates_are_their_deviations() {
        let (power, tail) = ([100.0, 0.25, 2.5, 3.0], ByParity { even: 2.0, odd: 0.5 });
        let sum = |energy: &Energy| {
            let known: f64 = (1..4).map(|l| energy.per_band()[l] * power[l]).sum();
            known + tail.dot(energy.beyond_by_class(3))
        };
        let other = |per_band: [f64; 4], even, odd| {
            Energy::new(Domain::Sphere, per_band.to_vec(), ByParity { even, odd })
        };
        let others = [other([1.0, 4.1, 1.8, 0.5], 3.1, 5.0), other([9.0, 3.7, 2.1, 0.6], 3.0, 5.2)];
        let expected = others.each_ref().map(|e| (sum(e) - sum(&energy())).abs());
        let estimated = energy().with_estimates(&others);
        let got = estimated.errors().unwrap().of_sum(&power, tail);
        assert!((got / expected[0].max(expected[1]) - 1.0).abs() < 1e-13, "{got}, {expected:?}");
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        let stated = estimated.per_band_stderr().unwrap();
        assert!(stated.iter().zip([8.0, 0.3, 0.2, 0.1]).all(|(a, b)| close(*a, b)), "{stated:?}");
        let totals = estimated.centred_stderr();
        assert!(close(totals.even, 0.1) && close(totals.odd, 0.2), "{totals:?}");
        // Energy that moves between bands of equal factors changes nothing.
        let moved = energy().with_estimates(&[other([9.0, 4.5, 2.0, 0.0], 3.0, 5.0)]);
        assert!(moved.errors().unwrap().of_sum(&[1.0; 4], ByParity::both(1.0)) < 1e-15);
        // Fewer bands and a multiple, which has the square of the factor.
        let part = estimated.truncated(1).of_multiple(-3.0);
        let expected = 9.0 * estimated.errors().unwrap().of_sum(&power[..2], tail);
        let got = part.errors().unwrap().of_sum(&power, tail);
        assert!((got / expected - 1.0).abs() < 1e-13, "{got} and {expected}");
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
