use num_complex::Complex;

use crate::error::Error;
use crate::limits::MAX_KMAX;
use crate::memory::resize;
use crate::real::Real;

/// The Fourier coefficients `c(k1, k2)` of a real measure or function on the torus, for |k1|, |k2| <=
/// kmax.
///
/// Only half of them are stored, since `c(-k1, -k2)` is the complex conjugate of `c(k1, k2)`.
#[derive(Clone, Debug, PartialEq)]
pub struct TorusCoefficients<R = f64> {
    kmax: usize,
    values: Vec<Complex<R>>,
}

impl<R: Real> TorusCoefficients<R> {
    /// Returns coefficients that are all zero.
    ///
    /// # Errors
    ///
    /// [`Error::FrequencyTooLarge`] if `kmax` exceeds [`MAX_KMAX`]; [`Error::OutOfMemory`] if
    /// allocation of the coefficients fails.
    pub fn zeros(kmax: usize) -> Result<Self, Error> {
        Ok(Self { kmax, values: zeros(kmax, kmax.saturating_add(1))? })
    }

    /// Returns the maximum frequency, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.kmax
    }

    /// Returns `c(k1, k2)`; `None` if a frequency is beyond kmax.
    #[must_use]
    pub fn get(&self, k1: i32, k2: i32) -> Option<Complex<R>> {
        let (line, column) = if k2 < 0 { (k1.checked_neg()?, k2) } else { (k1, k2) };
        let (line, column) =
            (line_of(line, self.kmax)?, usize::try_from(column.unsigned_abs()).ok()?);
        if column > self.kmax {
            return None;
        }
        let value = *self.values.get(line * (self.kmax + 1) + column)?;
        Some(if k2 < 0 { value.conj() } else { value })
    }

    /// Returns the coefficients with k2 >= 0: `c(k1, k2)` at `(k1 + kmax) (kmax + 1) + k2`.
    #[must_use]
    pub fn values(&self) -> &[Complex<R>] {
        &self.values
    }

    /// Returns the coefficients in the order of [`Self::values`]. Both `c(k1, 0)` and `c(-k1, 0)`
    /// are stored; callers keep them conjugate to each other.
    #[must_use]
    pub fn values_mut(&mut self) -> &mut [Complex<R>] {
        &mut self.values
    }
}

/// The Fourier coefficients `c(k1, k2)` of a complex measure or function on the torus, for |k1|, |k2|
/// <= kmax.
#[derive(Clone, Debug, PartialEq)]
pub struct ComplexTorusCoefficients<R = f64> {
    kmax: usize,
    values: Vec<Complex<R>>,
}

impl<R: Real> ComplexTorusCoefficients<R> {
    /// Returns coefficients that are all zero.
    ///
    /// # Errors
    ///
    /// As for [`TorusCoefficients::zeros`].
    pub fn zeros(kmax: usize) -> Result<Self, Error> {
        Ok(Self { kmax, values: zeros(kmax, kmax.saturating_mul(2).saturating_add(1))? })
    }

    /// Returns the maximum frequency, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.kmax
    }

    /// Returns `c(k1, k2)`; `None` if a frequency is beyond kmax.
    #[must_use]
    pub fn get(&self, k1: i32, k2: i32) -> Option<Complex<R>> {
        let (line, column) = (line_of(k1, self.kmax)?, line_of(k2, self.kmax)?);
        self.values.get(line * (2 * self.kmax + 1) + column).copied()
    }

    /// Returns the coefficients: `c(k1, k2)` at `(k1 + kmax) (2 kmax + 1) + k2 + kmax`.
    #[must_use]
    pub fn values(&self) -> &[Complex<R>] {
        &self.values
    }

    /// Returns the coefficients in the order of [`Self::values`].
    #[must_use]
    pub fn values_mut(&mut self) -> &mut [Complex<R>] {
        &mut self.values
    }

    /// Replaces the coefficients by `a + i b` of the coefficients of a real and an imaginary part,
    /// in the order of [`TorusCoefficients::values`].
    pub(crate) fn set_parts(&mut self, [a, b]: [&[Complex<f64>]; 2]) {
        let (kmax, last) = (self.kmax, self.values.len() - 1);
        let rows = a.chunks_exact(kmax + 1).zip(b.chunks_exact(kmax + 1));
        for (line, (a, b)) in rows.enumerate() {
            for (column, (a, b)) in a.iter().zip(b).enumerate() {
                let index = line * (2 * kmax + 1) + kmax + column;
                // Line k2 = 0 has both signs of k1.
                if column > 0 {
                    self.values[last - index] = narrow(a.re + b.im, b.re - a.im);
                }
                self.values[index] = narrow(a.re - b.im, a.im + b.re);
            }
        }
    }

    /// Writes the coefficients of the real and of the imaginary part of the function.
    pub(crate) fn split_into(&self, [a, b]: [&mut [Complex<f64>]; 2]) {
        let (kmax, last) = (self.kmax, self.values.len() - 1);
        let rows = a.chunks_exact_mut(kmax + 1).zip(b.chunks_exact_mut(kmax + 1));
        for (line, (a, b)) in rows.enumerate() {
            for (column, (a, b)) in a.iter_mut().zip(b).enumerate() {
                let index = line * (2 * kmax + 1) + kmax + column;
                let (c, d) = (wide(self.values[index]), wide(self.values[last - index]));
                // Halves first, since the sum can overflow.
                let (c, d) = (c * 0.5, d * 0.5);
                *a = Complex::new(c.re + d.re, c.im - d.im);
                *b = Complex::new(c.im + d.im, d.re - c.re);
            }
        }
    }
}

fn wide<R: Real>(value: Complex<R>) -> Complex<f64> {
    Complex::new(value.re.to_f64(), value.im.to_f64())
}

fn narrow<R: Real>(re: f64, im: f64) -> Complex<R> {
    Complex { re: R::of(re), im: R::of(im) }
}

/// Returns one zero for each k1 and each of `columns` frequencies k2.
fn zeros<R: Real>(kmax: usize, columns: usize) -> Result<Vec<Complex<R>>, Error> {
    if kmax > MAX_KMAX {
        return Err(Error::FrequencyTooLarge { kmax, max: MAX_KMAX });
    }
    let mut values = Vec::new();
    resize(&mut values, (2 * kmax + 1) * columns)?;
    Ok(values)
}

/// Returns k + kmax; `None` if k is beyond kmax.
fn line_of(k: i32, kmax: usize) -> Option<usize> {
    let line = kmax.checked_add_signed(isize::try_from(k).ok()?)?;
    (line <= 2 * kmax).then_some(line)
}
