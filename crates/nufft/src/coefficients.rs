use num_complex::Complex;

use crate::error::Error;
use crate::limits::MAX_KMAX;
use crate::memory::resize;

/// The Fourier coefficients `c(k1, k2)` of a real measure on the torus, for |k1|, |k2| <= kmax.
///
/// Only half of them are stored, since `c(-k1, -k2)` is the complex conjugate of `c(k1, k2)`.
#[derive(Clone, Debug, PartialEq)]
pub struct TorusCoefficients {
    kmax: usize,
    values: Vec<Complex<f64>>,
}

impl TorusCoefficients {
    /// Returns coefficients that are all zero.
    ///
    /// # Errors
    ///
    /// [`Error::FrequencyTooLarge`] if `kmax` exceeds [`MAX_KMAX`]; [`Error::OutOfMemory`] if
    /// allocation of the coefficients fails.
    pub fn zeros(kmax: usize) -> Result<Self, Error> {
        if kmax > MAX_KMAX {
            return Err(Error::FrequencyTooLarge { kmax, max: MAX_KMAX });
        }
        let mut values = Vec::new();
        resize(&mut values, (2 * kmax + 1) * (kmax + 1))?;
        Ok(Self { kmax, values })
    }

    /// Returns the maximum frequency, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.kmax
    }

    /// Returns `c(k1, k2)`; `None` if a frequency is beyond kmax.
    #[must_use]
    pub fn get(&self, k1: i32, k2: i32) -> Option<Complex<f64>> {
        let (k1, k2) = (isize::try_from(k1).ok()?, isize::try_from(k2).ok()?);
        if k1.unsigned_abs().max(k2.unsigned_abs()) > self.kmax {
            return None;
        }
        let (line, column) = if k2 < 0 { (-k1, -k2) } else { (k1, k2) };
        let line = self.kmax.checked_add_signed(line)?;
        let value = *self.values.get(line * (self.kmax + 1) + column.unsigned_abs())?;
        Some(if k2 < 0 { value.conj() } else { value })
    }

    /// Returns the coefficients with k2 >= 0: `c(k1, k2)` at `(k1 + kmax) (kmax + 1) + k2`.
    #[must_use]
    pub fn values(&self) -> &[Complex<f64>] {
        &self.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut [Complex<f64>] {
        &mut self.values
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex;

    use super::TorusCoefficients;
    use crate::error::Error;
    use crate::limits::MAX_KMAX;

    #[test]
    fn negative_frequencies_are_conjugates() {
        let mut c = TorusCoefficients::zeros(2).unwrap();
        for (k, value) in c.values_mut().iter_mut().enumerate() {
            *value = Complex::new(k as f64, 1.0);
        }
        assert_eq!(c.get(-2, 0), Some(Complex::new(0.0, 1.0)));
        assert_eq!(c.get(1, 2), Some(Complex::new(11.0, 1.0)));
        assert_eq!(c.get(-1, -2), Some(Complex::new(11.0, -1.0)));
        for beyond in [3, -3, i32::MAX, i32::MIN] {
            assert_eq!((c.get(beyond, 0), c.get(0, beyond)), (None, None));
        }
        for kmax in [MAX_KMAX + 1, usize::MAX] {
            assert_eq!(
                TorusCoefficients::zeros(kmax),
                Err(Error::FrequencyTooLarge { kmax, max: MAX_KMAX })
            );
        }
    }
}
