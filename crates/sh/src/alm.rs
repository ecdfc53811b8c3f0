use core::ops::{Index, IndexMut};

use num_complex::Complex;

use crate::{Error, LmIndex};

/// Harmonic coefficients `a_lm` of a real function or measure, stored for `m >= 0`.
///
/// ```text
/// a_lm = integral over the sphere of f(s) conj Y_lm(s) ds,      a_{l,-m} = (-1)^m conj a_lm
/// ```
///
/// `Y_lm` is orthonormal with the Condon-Shortley phase; the layout is that of [`LmIndex`]. The
/// type does not force the imaginary part of `a_l0` to zero; callers that write values must do so.
///
/// # Examples
///
/// ```
/// use num_complex::Complex;
/// use sphvar_sh::Alm;
///
/// let mut alm = Alm::zeros(3)?;
/// alm[(2, 1)] = Complex::new(3.0, 4.0);
/// assert_eq!(alm.coefficient(2, -1), Complex::new(-3.0, 4.0));
/// // |a_21|^2 + |a_2-1|^2
/// assert_eq!(alm.energy_per_degree(), [0.0, 0.0, 50.0, 0.0]);
/// assert_eq!(alm.power_per_degree(), [0.0, 0.0, 10.0, 0.0]);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Alm {
    index: LmIndex,
    values: Vec<Complex<f64>>,
}

impl Alm {
    /// Returns coefficients for degrees `0..=lmax`, all zero.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] from [`LmIndex::new`]; [`Error::OutOfMemory`] if allocation fails.
    ///
    /// # Performance
    ///
    /// Uses `8 (lmax + 1)(lmax + 2)` bytes, 3.2 GB for `lmax = 20000`.
    pub fn zeros(lmax: usize) -> Result<Self, Error> {
        let index = LmIndex::new(lmax)?;
        let len = index.len();
        let mut values = Vec::new();
        values
            .try_reserve_exact(len)
            .map_err(|_| Error::OutOfMemory { len, bytes_each: size_of::<Complex<f64>>() })?;
        values.resize(len, Complex::ZERO);
        Ok(Self { index, values })
    }

    /// Returns coefficients for degrees `0..=lmax` from a vector in [`LmIndex`] order.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] from [`LmIndex::new`]; [`Error::CoefficientCount`] if the length
    /// of the vector is not `(lmax + 1)(lmax + 2) / 2`.
    pub fn from_values(lmax: usize, values: Vec<Complex<f64>>) -> Result<Self, Error> {
        let index = LmIndex::new(lmax)?;
        let (expected, got) = (index.len(), values.len());
        if expected == got {
            Ok(Self { index, values })
        } else {
            Err(Error::CoefficientCount { lmax, expected, got })
        }
    }

    /// Returns the layout.
    #[must_use]
    pub const fn index(&self) -> LmIndex {
        self.index
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub const fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Returns all stored coefficients in [`LmIndex`] order.
    #[must_use]
    pub fn values(&self) -> &[Complex<f64>] {
        &self.values
    }

    /// Returns all stored coefficients in [`LmIndex`] order, mutably.
    #[must_use]
    pub fn values_mut(&mut self) -> &mut [Complex<f64>] {
        &mut self.values
    }

    /// Returns the stored coefficients in [`LmIndex`] order and discards the layout.
    #[must_use]
    pub fn into_values(self) -> Vec<Complex<f64>> {
        self.values
    }

    /// Returns the coefficients of `l = m..=lmax` at fixed `m`.
    ///
    /// # Panics
    ///
    /// Panics if `m > lmax`.
    #[must_use]
    pub fn column(&self, m: usize) -> &[Complex<f64>] {
        &self.values[self.index.column(m)]
    }

    /// Returns the coefficients of `l = m..=lmax` at fixed `m`, mutably.
    ///
    /// # Panics
    ///
    /// Panics if `m > lmax`.
    #[must_use]
    pub fn column_mut(&mut self, m: usize) -> &mut [Complex<f64>] {
        &mut self.values[self.index.column(m)]
    }

    /// Returns `a_lm` for an order of either sign, by `a_{l,-m} = (-1)^m conj a_lm`.
    ///
    /// # Panics
    ///
    /// Panics unless `|m| <= l <= lmax`.
    #[must_use]
    pub fn coefficient(&self, l: usize, m: i64) -> Complex<f64> {
        // An order beyond usize (32-bit targets) is invalid for every degree; usize::MAX makes `at`
        // panic.
        let order = usize::try_from(m.unsigned_abs()).unwrap_or(usize::MAX);
        let stored = self[(l, order)];
        match (m < 0, order % 2 == 0) {
            (false, _) => stored,
            (true, true) => stored.conj(),
            (true, false) => -stored.conj(),
        }
    }

    /// Returns the energy of every degree, `E_l = sum_{m=-l}^{l} |a_lm|^2`, for `l = 0..=lmax`.
    ///
    /// Orders `m > 0` count twice. All terms are positive, so the relative error of each `E_l` is
    /// at most `(l + 4) EPSILON`.
    #[must_use]
    pub fn energy_per_degree(&self) -> Vec<f64> {
        let mut energy = vec![0.0; self.lmax() + 1];
        for m in 0..=self.lmax() {
            let weight = if m == 0 { 1.0 } else { 2.0 };
            for (e, a) in energy[m..].iter_mut().zip(self.column(m)) {
                *e += weight * a.norm_sqr();
            }
        }
        energy
    }

    /// Returns the power of every degree, `P_l = E_l / (2l + 1)`, for `l = 0..=lmax`.
    #[must_use]
    pub fn power_per_degree(&self) -> Vec<f64> {
        let mut power = self.energy_per_degree();
        let mut orders = 1.0;
        for p in &mut power {
            *p /= orders;
            orders += 2.0;
        }
        power
    }
}

/// `alm[(l, m)]` for `0 <= m <= l <= lmax`; panics for other indices.
impl Index<(usize, usize)> for Alm {
    type Output = Complex<f64>;

    fn index(&self, (l, m): (usize, usize)) -> &Self::Output {
        &self.values[self.index.at(l, m)]
    }
}

impl IndexMut<(usize, usize)> for Alm {
    fn index_mut(&mut self, (l, m): (usize, usize)) -> &mut Self::Output {
        let i = self.index.at(l, m);
        &mut self.values[i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns coefficients with values that identify their (l, m), to detect wrong positions.
    fn tagged(lmax: usize) -> Alm {
        let mut alm = Alm::zeros(lmax).unwrap();
        for (l, m) in alm.index().iter() {
            alm[(l, m)] = Complex::new(l as f64, m as f64);
        }
        alm
    }

    #[test]
    fn columns_and_conjugate_symmetry() {
        let alm = tagged(9);
        for m in 0..=9 {
            for (l, a) in (m..).zip(alm.column(m)) {
                assert_eq!(*a, Complex::new(l as f64, m as f64), "l = {l}, m = {m}");
                let order = i64::try_from(m).unwrap();
                let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
                assert_eq!(alm.coefficient(l, order), *a, "l = {l}, m = {m}");
                if m > 0 {
                    assert_eq!(alm.coefficient(l, -order), a.conj() * sign, "l = {l}, m = -{m}");
                }
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "small integers, exact in f64")]
    fn energy_is_the_sum_over_both_signs() {
        let alm = tagged(12);
        let (energy, power) = (alm.energy_per_degree(), alm.power_per_degree());
        for l in 0..=12_usize {
            let order = i64::try_from(l).unwrap();
            let slow: f64 = (-order..=order).map(|m| alm.coefficient(l, m).norm_sqr()).sum();
            assert_eq!(energy[l], slow, "l = {l}");
            assert_eq!(power[l], slow / (2 * l + 1) as f64, "l = {l}");
        }
    }

    #[test]
    fn wrong_sizes_are_errors() {
        assert_eq!(
            Alm::from_values(2, vec![Complex::ZERO; 5]),
            Err(Error::CoefficientCount { lmax: 2, expected: 6, got: 5 })
        );
        assert!(matches!(Alm::zeros(usize::MAX), Err(Error::DegreeTooLarge { .. })));
        let values = tagged(3).into_values();
        assert_eq!(Alm::from_values(3, values), Ok(tagged(3)));
    }
}
