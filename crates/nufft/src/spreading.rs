mod interpolate;
mod spread;

use pulp::{Arch, Simd};

use crate::cells::{Cells, Locator, Places};
use crate::real::Real;
use crate::threads::{Threads, share, zip_all};
use crate::window::{MAX_WIDTH, Window, WindowTable};
use interpolate::{Interpolate, InterpolateGradient};
use spread::{BAND_ROWS, Spread, SpreadScratch};

/// Spreads points onto a grid with the window, and interpolates grid values at points.
///
/// A grid has rows of [`Self::stride`] numbers. The columns of a full turn have a margin on either
/// side for values that belong to the other end of the row. [`Self::margin`] further rows precede
/// the first row and follow the last one; the caller folds them.
#[derive(Clone, Debug)]
pub struct Spreading<T> {
    locator: Locator,
    table: WindowTable<T>,
    /// The number of points at one place that can be added with negligible rounding error.
    run: usize,
}

impl<T: Real> Spreading<T> {
    /// Returns the stages for a grid with `cells` cells per turn, for rows and columns, and `rows`
    /// rows between its margins, for accuracy `epsilon`.
    pub fn new(cells: [usize; 2], rows: usize, window: Window, epsilon: f64) -> Self {
        // If all rounding errors have the same sign, they amount to half this number times EPSILON.
        // More than 64, for which sums are exact enough at any accuracy, take a 40th of epsilon.
        let units = epsilon / T::EPSILON;
        let run = units.clamp(16.0, 64.0).max((0.05 * units).min(256.0));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "16 to 256")]
        let run = run as usize;
        let table = window.table();
        Self { locator: Locator::new(cells, rows, &table), table, run }
    }

    /// Returns the distance between vertically adjacent numbers in memory.
    pub fn stride(&self) -> usize {
        self.locator.cells[1] + self.locator.margin + MAX_WIDTH
    }

    /// Returns the number of margin rows and columns before the first cell, and of rows after the
    /// last.
    pub fn margin(&self) -> usize {
        self.locator.margin
    }

    /// Returns the length of a grid.
    pub fn grid_len(&self) -> usize {
        self.locator.n_rows() * self.stride()
    }

    /// Replaces `cells` by the points, sorted by tile, with weights (1 if `None`) multiplied by
    /// `scale`.
    ///
    /// # Panics
    ///
    /// Panics if there are fewer weights than points.
    pub fn locate<R: Real>(
        &self,
        arch: Arch,
        points: &impl Places,
        weights: Option<&[R]>,
        scale: f64,
        threads: Threads,
        cells: &mut Cells<T>,
    ) {
        self.locator.locate(arch, points, weights, scale, threads, cells);
    }

    /// Replaces the grid by the points spread on it.
    pub fn spread(&self, arch: Arch, cells: &Cells<T>, threads: Threads, grid: &mut [T]) {
        T::spread(self, arch, cells, threads, grid);
    }

    /// Replaces G grids by the points with different weights, which share the values of the
    /// windows. `weights` are in the caller's order of points; `None` means those of `cells`.
    pub(crate) fn spread_together<const G: usize>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        weights: Option<&[[T; G]]>,
        threads: Threads,
        mut grids: [&mut [T]; G],
    ) {
        // A band of rows adds to itself and to the next one. All even bands are spread before all
        // odd ones, so that bands of the same parity are independent and sums do not depend on the
        // number of threads.
        let band_len = BAND_ROWS * self.stride();
        let spread = |scratch: &mut SpreadScratch<T>, band: usize, grids: [&mut [T]; G]| {
            arch.dispatch(Spread { spreading: self, cells, weights, band, scratch, grids });
        };
        if threads == Threads::Caller {
            let scratch = &mut SpreadScratch::default();
            // Every odd band directly after the even bands around it, while they are in the cache.
            let n_bands = self.locator.n_rows().div_ceil(BAND_ROWS);
            for even in (0..n_bands + 2).step_by(2) {
                for band in [Some(even), even.checked_sub(1)].into_iter().flatten() {
                    let rows = grids.each_mut().map(|grid| {
                        let end = grid.len().min((band + 2) * band_len);
                        grid.get_mut(band * band_len..end).unwrap_or_default()
                    });
                    spread(scratch, band, rows);
                }
            }
            return;
        }
        let mut scratch = Vec::new();
        threads.resize(&mut scratch);
        for first in [0, 1] {
            let bands = grids.each_mut().map(|grid| {
                let start = grid.len().min(first * band_len);
                grid[start..].chunks_mut(2 * band_len)
            });
            let bands = (first..).step_by(2).zip(zip_all(bands));
            share(&mut scratch, bands, |scratch, (band, grids)| spread(scratch, band, grids));
        }
    }

    /// Writes the values of several functions at the points. `grids` holds their grids one after
    /// the other, and `sizes` the factors of their values. Function b at point i is written to
    /// `out[i * n_functions + b]`, in the caller's order of points.
    ///
    /// # Panics
    ///
    /// Panics if `out` is too short.
    pub fn interpolate(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        grids: &[T],
        sizes: &[f64],
        threads: Threads,
        out: &mut [f64],
    ) {
        T::interpolate(self, arch, cells, grids, sizes, threads, out);
    }

    pub(crate) fn interpolate_body<R: Real>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        grids: &[T],
        sizes: &[f64],
        threads: Threads,
        out: &mut [R],
    ) {
        let len = (cells.part_len() * sizes.len()).max(1);
        let parts = cells.parts().iter().zip(out.chunks_mut(len));
        share(&mut vec![(); threads.count()], parts, |(), (part, out)| {
            arch.dispatch(Interpolate { spreading: self, part, grids, sizes, out });
        });
    }

    /// Writes `size` times the value of a function and its derivatives by both coordinates, per
    /// turn, at the points.
    pub(crate) fn interpolate_gradient<R: Real>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        grid: &[T],
        size: f64,
        threads: Threads,
        out: &mut [[R; 3]],
    ) {
        let parts = cells.parts().iter().zip(out.chunks_mut(cells.part_len().max(1)));
        share(&mut vec![(); threads.count()], parts, |(), (part, out)| {
            arch.dispatch(InterpolateGradient { spreading: self, part, grid, size, out });
        });
    }
}

/// Work that is compiled for every padded width P of the window and its half H, with and without
/// fused multiply-adds.
pub(crate) trait ByWidth {
    fn run<const P: usize, const H: usize, const FUSED: bool>(self);
}

#[inline(always)]
pub(crate) fn for_width<S: Simd, W: ByWidth>(padded: usize, work: W) {
    match (padded, S::F64_LANES > 1) {
        (8, true) => work.run::<8, 4, true>(),
        (12, true) => work.run::<12, 6, true>(),
        (_, true) => work.run::<MAX_WIDTH, { MAX_WIDTH / 2 }, true>(),
        (8, false) => work.run::<8, 4, false>(),
        (12, false) => work.run::<12, 6, false>(),
        (_, false) => work.run::<MAX_WIDTH, { MAX_WIDTH / 2 }, false>(),
    }
}
