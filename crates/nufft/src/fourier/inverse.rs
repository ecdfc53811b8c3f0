use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};

use super::{COLUMNS, Fourier, FourierScratch};
use crate::real::Real;
use crate::spreading::Spreading;

impl<T: Real> Fourier<T> {
    /// Replaces a grid and its margins by the values of `scale` times a series, in the order of
    /// [`TorusCoefficients::values`](crate::TorusCoefficients::values), such that interpolation
    /// with the window returns the series.
    pub(crate) fn run_inverse<R: Real>(
        &self,
        arch: Arch,
        coefficients: &[Complex<R>],
        scale: f64,
        spreading: &Spreading<T>,
        scratch: &mut FourierScratch<T>,
        grid: &mut [T],
    ) {
        arch.dispatch(Run { fourier: self, coefficients, scale, spreading, scratch, grid });
    }

    /// Transforms coefficients to the spectra of rows.
    #[inline(always)]
    fn invert_columns<R: Real>(
        &self,
        coefficients: &[Complex<R>],
        scale: f64,
        scratch: &mut FourierScratch<T>,
    ) {
        let FourierScratch { spectra, columns, fft, .. } = scratch;
        let (n, kmax) = (self.cells, self.kmax);
        let corrections = self.correction.as_chunks::<COLUMNS>().0;
        let blocks = spectra.chunks_exact_mut(n * COLUMNS).zip(corrections);
        for (block, (spectra, corrections)) in blocks.enumerate() {
            columns.fill(Complex::default());
            for (line, coefficients) in coefficients.chunks_exact(kmax + 1).enumerate() {
                let (row, size) = self.row_of(line);
                let coefficients = coefficients[block * COLUMNS..].iter();
                for (c, column) in coefficients.zip(columns.chunks_exact_mut(n)) {
                    let (re, im) = (T::of(c.re.to_f64() * scale), T::of(c.im.to_f64() * scale));
                    column[row] = Complex { re, im } * self.correction[size];
                }
            }
            let used = self.used_columns(block);
            self.inverse_fft.process_with_scratch(&mut columns[..used * n], fft);
            for (row, values) in spectra.as_chunks_mut::<COLUMNS>().0.iter_mut().enumerate() {
                for (i, value) in values.iter_mut().enumerate() {
                    *value = columns[i * n + row] * corrections[i];
                }
            }
        }
    }

    /// Transforms the spectra of rows to real rows, two at a time.
    #[inline(always)]
    fn invert_rows(
        &self,
        rows: &mut [T],
        stride: usize,
        margin: usize,
        scratch: &mut FourierScratch<T>,
    ) {
        let FourierScratch { pair, spectra, fft, .. } = scratch;
        let (n, kmax) = (self.cells, self.kmax);
        let pair = &mut pair[..n];
        for (first, rows) in (0..n).step_by(2).zip(rows.chunks_exact_mut(2 * stride)) {
            // The transform of a + i b, for real a and b with spectra at k and their conjugates at
            // -k. Both are real at k = 0.
            pair[kmax + 1..n - kmax].fill(Complex::default());
            for (block, spectra) in spectra.chunks_exact(n * COLUMNS).enumerate() {
                let (a, b) = spectra[first * COLUMNS..][..2 * COLUMNS].split_at(COLUMNS);
                let k = block * COLUMNS;
                for i in 0..self.used_columns(block) {
                    let (a, b) = (a[i], b[i]);
                    pair[k + i] = Complex { re: a.re - b.im, im: a.im + b.re };
                    if k + i > 0 {
                        pair[n - k - i] = Complex { re: a.re + b.im, im: b.re - a.im };
                    } else {
                        pair[0] = Complex { re: a.re, im: b.re };
                    }
                }
            }
            self.inverse_fft.process_with_scratch(pair, fft);
            let (one, other) = rows.split_at_mut(stride);
            let places = one[margin..].iter_mut().zip(&mut other[margin..]);
            for ((one, other), z) in places.zip(&*pair) {
                (*one, *other) = (z.re, z.im);
            }
            for row in [one, other] {
                row.copy_within(n..n + margin, 0);
                row.copy_within(margin..stride - n, margin + n);
            }
        }
    }
}

struct Run<'a, T, R> {
    fourier: &'a Fourier<T>,
    coefficients: &'a [Complex<R>],
    scale: f64,
    spreading: &'a Spreading<T>,
    scratch: &'a mut FourierScratch<T>,
    grid: &'a mut [T],
}

impl<T: Real, R: Real> NullaryFnOnce for Run<'_, T, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { fourier, coefficients, scale, spreading, scratch, grid } = self;
        let (n, stride, margin) = (fourier.cells, spreading.stride(), spreading.margin());
        scratch.resize(fourier);
        fourier.invert_columns(coefficients, scale, scratch);
        fourier.invert_rows(&mut grid[margin * stride..][..n * stride], stride, margin, scratch);
        grid.copy_within(n * stride..(n + margin) * stride, 0);
        grid.copy_within(margin * stride..2 * margin * stride, (margin + n) * stride);
    }
}
