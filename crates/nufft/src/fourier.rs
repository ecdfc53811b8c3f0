mod inverse;

use std::ops::AddAssign;
use std::sync::Arc;

use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};
use rustfft::{Fft, FftDirection};

use crate::real::Real;
use crate::spreading::Spreading;
use crate::window::Window;

/// Number of columns transformed together, so that they share cache lines.
const COLUMNS: usize = 8;

/// Fourier transforms between a real grid on the torus and coefficients, corrected for the window.
#[derive(Clone)]
pub(crate) struct Fourier<T> {
    kmax: usize,
    /// Grid cells per turn, in both directions.
    cells: usize,
    /// The reciprocal of the window's transform at each k >= 0, padded with zeros to a multiple of
    /// `COLUMNS`.
    correction: Box<[T]>,
    fft: Arc<dyn Fft<T>>,
    inverse_fft: Arc<dyn Fft<T>>,
}

/// Workspace of [`Fourier`].
#[derive(Debug, Default)]
pub(crate) struct FourierScratch<T> {
    pair: Vec<Complex<T>>,
    /// Indexed by block of `COLUMNS` columns, row, and column.
    spectra: Vec<Complex<T>>,
    columns: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

impl<T: Real> Fourier<T> {
    pub(crate) fn new(kmax: usize, cells: usize, window: Window) -> Self {
        let mut correction: Vec<T> =
            window.transform(cells, kmax).into_iter().map(|t| T::of(1.0 / t)).collect();
        correction.resize((kmax + 1).next_multiple_of(COLUMNS), T::default());
        let [fft, inverse_fft] = [FftDirection::Forward, FftDirection::Inverse]
            .map(|direction| T::fourier_plan(cells, direction));
        Self { kmax, cells, correction: correction.into(), fft, inverse_fft }
    }

    /// Returns the length of the spectra of all rows.
    pub(crate) fn spectra_len(&self) -> usize {
        self.cells * self.correction.len()
    }

    /// Replaces `out` by `scale` times the coefficients of a grid that points were spread on, in
    /// the order of [`TorusCoefficients::values`](crate::TorusCoefficients::values). Overwrites the
    /// grid.
    pub(crate) fn run<R: Real>(
        &self,
        arch: Arch,
        grid: &mut [T],
        spreading: &Spreading<T>,
        scale: f64,
        scratch: &mut FourierScratch<T>,
        out: &mut [Complex<R>],
    ) {
        arch.dispatch(Run { fourier: self, grid, spreading, scale, scratch, out });
    }

    /// Adds values beyond the ends of rows and columns to their opposite ends.
    #[inline(always)]
    fn fold(&self, grid: &mut [T], stride: usize, margin: usize) {
        let n = self.cells;
        for row in grid.chunks_exact_mut(stride) {
            fold_row(row, n, margin);
        }
        let (before, rest) = grid.split_at_mut(margin * stride);
        let (body, after) = rest.split_at_mut(n * stride);
        add(&mut body[(n - margin) * stride..], before);
        add(body, after);
    }

    /// Transforms the rows of a folded grid, two at a time, to frequencies from 0 to kmax.
    #[inline(always)]
    fn transform_rows(&self, rows: &[T], stride: usize, scratch: &mut FourierScratch<T>) {
        let FourierScratch { pair, spectra, fft, .. } = scratch;
        let (n, half) = (self.cells, T::of(0.5));
        let corrections = self.correction.as_chunks::<COLUMNS>().0;
        for (first, rows) in (0..n).step_by(2).zip(rows.chunks_exact(2 * stride)) {
            let (one, other) = rows.split_at(stride);
            for (z, (&re, &im)) in pair[..n].iter_mut().zip(one.iter().zip(other)) {
                *z = Complex { re, im };
            }
            self.fft.process_with_scratch(&mut pair[..n], fft);
            pair[n] = pair[0];
            // The transform of a + i b at k and n - k separates into those of the real a and b.
            for (block, corrections) in corrections.iter().enumerate() {
                let k = block * COLUMNS;
                let here = &pair[k..k + COLUMNS];
                let there = &pair[n + 1 - k - COLUMNS..=n - k];
                let place = &mut spectra[(block * n + first) * COLUMNS..][..2 * COLUMNS];
                let (a, b) = place.split_at_mut(COLUMNS);
                for i in 0..COLUMNS {
                    let (here, there) = (here[i], there[COLUMNS - 1 - i].conj());
                    let factor = corrections[i] * half;
                    let difference = here - there;
                    a[i] = (here + there) * factor;
                    b[i] = Complex { re: difference.im, im: -difference.re } * factor;
                }
            }
        }
    }

    /// Transforms the columns of the spectra to coefficients.
    #[inline(always)]
    fn transform_columns<R: Real>(
        &self,
        scale: f64,
        scratch: &mut FourierScratch<T>,
        out: &mut [Complex<R>],
    ) {
        let FourierScratch { spectra, columns, fft, .. } = scratch;
        let (n, kmax) = (self.cells, self.kmax);
        for (block, spectra) in spectra.chunks_exact(n * COLUMNS).enumerate() {
            for (row, values) in spectra.as_chunks::<COLUMNS>().0.iter().enumerate() {
                for (i, value) in values.iter().enumerate() {
                    columns[i * n + row] = *value;
                }
            }
            let used = self.used_columns(block);
            self.fft.process_with_scratch(&mut columns[..used * n], fft);
            for (line, out) in out.chunks_exact_mut(kmax + 1).enumerate() {
                let (row, size) = self.row_of(line);
                let out = out[block * COLUMNS..].iter_mut();
                for (out, column) in out.zip(columns.chunks_exact(n)) {
                    let value = column[row] * self.correction[size];
                    let value = Complex::new(value.re.to_f64(), value.im.to_f64()) * scale;
                    *out = Complex { re: R::of(value.re), im: R::of(value.im) };
                }
            }
        }
    }
}

impl<T> Fourier<T> {
    /// Returns the row of a frequency, which is `line - kmax`, and its absolute value. Negative
    /// frequencies are at the end of a column.
    #[inline(always)]
    fn row_of(&self, line: usize) -> (usize, usize) {
        let (n, kmax) = (self.cells, self.kmax);
        if line < kmax { (n - (kmax - line), kmax - line) } else { (line - kmax, line - kmax) }
    }

    /// Returns the number of columns of a block up to frequency kmax.
    #[inline(always)]
    fn used_columns(&self, block: usize) -> usize {
        (self.kmax + 1 - block * COLUMNS).min(COLUMNS)
    }
}

struct Run<'a, T, R> {
    fourier: &'a Fourier<T>,
    grid: &'a mut [T],
    spreading: &'a Spreading<T>,
    scale: f64,
    scratch: &'a mut FourierScratch<T>,
    out: &'a mut [Complex<R>],
}

impl<T: Real, R: Real> NullaryFnOnce for Run<'_, T, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { fourier, grid, spreading, scale, scratch, out } = self;
        let (stride, margin) = (spreading.stride(), spreading.margin());
        scratch.resize(fourier);
        fourier.fold(grid, stride, margin);
        fourier.transform_rows(&grid[margin * stride + margin..], stride, scratch);
        fourier.transform_columns(scale, scratch, out);
    }
}

impl<T: Real> FourierScratch<T> {
    fn resize(&mut self, fourier: &Fourier<T>) {
        let lengths = [&fourier.fft, &fourier.inverse_fft].map(|fft| fft.get_inplace_scratch_len());
        self.fft.resize(lengths[0].max(lengths[1]), Complex::default());
        self.pair.resize(fourier.cells + 1, Complex::default());
        self.columns.resize(fourier.cells * COLUMNS, Complex::default());
        self.spectra.resize(fourier.spectra_len(), Complex::default());
    }

    /// Returns the spectra, whose length grows with the square of kmax.
    pub(crate) fn spectra(&mut self) -> &mut Vec<Complex<T>> {
        &mut self.spectra
    }
}

/// Adds values beyond both ends of a row of `n` numbers to the opposite ends.
#[inline(always)]
pub(crate) fn fold_row<T: AddAssign + Copy>(row: &mut [T], n: usize, margin: usize) {
    let (before, rest) = row.split_at_mut(margin);
    let (body, after) = rest.split_at_mut(n);
    add(&mut body[n - margin..], before);
    add(body, after);
}

#[inline(always)]
fn add<T: AddAssign + Copy>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += *from;
    }
}
