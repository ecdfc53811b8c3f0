use pulp::Arch;
use rayon::prelude::*;

use super::products::{AddProducts, LANES};
use crate::{Error, Progress, Stopped};

/// Rows of a tile.
const TILE: usize = 64;

/// A dense matrix, row after row; rows are padded by zeros.
pub(super) struct Matrix {
    n_rows: usize,
    stride: usize,
    data: Vec<f64>,
}

impl Matrix {
    /// Returns a matrix of zeros.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if allocation fails.
    pub(super) fn zeros(n_rows: usize, n_columns: usize) -> Result<Self, Error> {
        // An odd number of cache lines keeps the starts of rows apart in the caches.
        let stride = (n_columns.div_ceil(LANES) | 1) * LANES;
        let len = n_rows * stride;
        let mut data = Vec::new();
        data.try_reserve_exact(len).map_err(|_| Error::OutOfMemory {
            pattern: "design",
            items: "entries of a matrix",
            len,
            bytes_each: size_of::<f64>(),
            remedy: "a lower degree or more points",
        })?;
        data.resize(len, 0.0);
        Ok(Self { n_rows, stride, data })
    }

    pub(super) fn n_rows(&self) -> usize {
        self.n_rows
    }

    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.stride..][..self.stride]
    }

    pub(super) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.stride..][..self.stride]
    }

    /// Replaces the lower triangle of `gram` by that of `J J^T`.
    pub(super) fn gram_into(
        &self,
        gram: &mut Self,
        progress: &dyn Progress,
    ) -> Result<(), Stopped> {
        let (arch, stride, out_stride) = (Arch::new(), self.stride, gram.stride);
        let tiles = gram.data.par_chunks_mut(TILE * out_stride).enumerate();
        tiles.try_for_each(|(tile, out)| {
            progress.tick(0.0)?;
            let first = tile * TILE;
            let n_left = TILE.min(self.n_rows - first);
            out.fill(0.0);
            let left = &self.data[first * stride..][..n_left * stride];
            for from in (0..first + n_left).step_by(TILE) {
                let n_right = TILE.min(self.n_rows - from);
                arch.dispatch(AddProducts {
                    left,
                    right: &self.data[from * stride..][..n_right * stride],
                    stride,
                    len: stride,
                    out: &mut out[from..],
                    out_stride,
                    shape: [n_left, n_right],
                    sign: 1.0,
                });
            }
            Ok(())
        })
    }

    /// Replaces the lower triangle of `self` by the Cholesky factor L of `A + mu`, where the lower
    /// triangle of `gram` is that of A; returns `false` if the matrix is not positive definite.
    ///
    /// Tiles of columns are factored from left to right (Golub and Van Loan 2013, section 4.2):
    /// each is updated with products of whole rows of those before.
    pub(super) fn factor(
        &mut self,
        gram: &Self,
        mu: f64,
        progress: &dyn Progress,
    ) -> Result<bool, Stopped> {
        let (arch, n, stride) = (Arch::new(), self.n_rows, self.stride);
        self.data.copy_from_slice(&gram.data);
        for first in (0..n).step_by(TILE) {
            progress.tick(0.0)?;
            let size = TILE.min(n - first);
            let (above, below) = self.data.split_at_mut((first + size) * stride);
            let panel = &mut above[first * stride..];
            // A tile's own columns are not yet those of the factor; multiples of LANES precede it.
            let update = |rows: &mut [f64], panel: &[f64]| {
                let n_rows = rows.len() / stride;
                let mut sums = [0.0; TILE * TILE];
                arch.dispatch(AddProducts {
                    left: rows,
                    right: panel,
                    stride,
                    len: first,
                    out: &mut sums,
                    out_stride: TILE,
                    shape: [n_rows, size],
                    sign: -1.0,
                });
                for (row, sums) in rows.chunks_exact_mut(stride).zip(sums.chunks_exact(TILE)) {
                    row[first..].iter_mut().zip(&sums[..size]).for_each(|(a, sum)| *a += sum);
                }
            };
            let before = panel.to_vec();
            update(panel, &before);
            for i in 0..size {
                let (done, row) = panel.split_at_mut(i * stride);
                let row = &mut row[first..][..=i];
                substitute(&mut row[..i], done, stride, first);
                row[i] += mu;
                let rest = row[i] - dot(&row[..i], &row[..i]);
                if rest.is_nan() || rest <= 0.0 {
                    return Ok(false);
                }
                row[i] = rest.sqrt();
            }
            let panel = &*panel;
            below.par_chunks_mut(TILE * stride).try_for_each(|rows| {
                progress.tick(0.0)?;
                update(rows, panel);
                for row in rows.chunks_exact_mut(stride) {
                    substitute(&mut row[first..][..size], panel, stride, first);
                }
                Ok(())
            })?;
        }
        Ok(true)
    }

    /// Replaces b by the solution of `L L^T x = b`.
    pub(super) fn solve(&self, b: &mut [f64]) {
        for i in 0..self.n_rows {
            let row = self.row(i);
            b[i] = (b[i] - dot(&row[..i], &b[..i])) / row[i];
        }
        for i in (0..self.n_rows).rev() {
            let row = self.row(i);
            b[i] /= row[i];
            let last = b[i];
            b[..i].iter_mut().zip(row).for_each(|(b, a)| *b -= last * a);
        }
    }
}

/// Replaces a part of a row by the solution x of `L x = row`, the rows of L at `first` in `panel`.
fn substitute(row: &mut [f64], panel: &[f64], stride: usize, first: usize) {
    for j in 0..row.len() {
        let factor = &panel[j * stride + first..][..=j];
        let (done, rest) = row.split_at_mut(j);
        rest[0] = (rest[0] - dot(done, &factor[..j])) / factor[j];
    }
}

/// Returns the sum of products, in eight sums that vectorize.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
