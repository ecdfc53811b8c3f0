mod interpolate;
mod spread;

use pulp::{Arch, Simd};

use crate::cells::{Cells, Locator, Places};
use crate::real::Real;
use crate::window::{MAX_WIDTH, Window, WindowTable};
use interpolate::{Interpolate, InterpolateGradient};
use spread::Spread;

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
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "16 to 64")]
        let run = (epsilon / T::EPSILON).clamp(16.0, 64.0) as usize;
        Self { locator: Locator::new(cells, rows, window.width()), table: window.table(), run }
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
        cells: &mut Cells<T>,
    ) {
        self.locator.locate(arch, points, weights, scale, cells);
    }

    /// Adds the points to the grid.
    pub fn spread(&self, arch: Arch, cells: &Cells<T>, grid: &mut [T]) {
        self.spread_together(arch, cells, None, [grid]);
    }

    /// Adds the points to G grids with different weights, which share the values of the windows.
    /// `weights` are in the caller's order of points; `None` means those of `cells`.
    pub(crate) fn spread_together<const G: usize>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        weights: Option<&[[T; G]]>,
        grids: [&mut [T]; G],
    ) {
        arch.dispatch(Spread { spreading: self, cells, weights, grids });
    }

    /// Writes the values of several functions at the points. `grids` holds their grids one after
    /// the other, and `sizes` the factors of their values. Function b at point i is written to
    /// `out[i * n_functions + b]`, in the caller's order of points.
    ///
    /// # Panics
    ///
    /// Panics if `out` is too short.
    pub fn interpolate<R: Real>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        grids: &[T],
        sizes: &[f64],
        out: &mut [R],
    ) {
        arch.dispatch(Interpolate { spreading: self, cells: cells.sorted(), grids, sizes, out });
    }

    /// Writes `size` times the value of a function and its derivatives by both coordinates, per
    /// turn, at the points.
    pub(crate) fn interpolate_gradient<R: Real>(
        &self,
        arch: Arch,
        cells: &Cells<T>,
        grid: &[T],
        size: f64,
        out: &mut [[R; 3]],
    ) {
        let cells = cells.sorted();
        arch.dispatch(InterpolateGradient { spreading: self, cells, grid, size, out });
    }
}

/// Work that is compiled for every padded width P of the window, with and without fused
/// multiply-adds.
pub(crate) trait ByWidth {
    fn run<const P: usize, const FUSED: bool>(self);
}

#[inline(always)]
pub(crate) fn for_width<S: Simd, W: ByWidth>(padded: usize, work: W) {
    match (padded, S::F64_LANES > 1) {
        (4, true) => work.run::<4, true>(),
        (8, true) => work.run::<8, true>(),
        (12, true) => work.run::<12, true>(),
        (16, true) => work.run::<16, true>(),
        (_, true) => work.run::<MAX_WIDTH, true>(),
        (4, false) => work.run::<4, false>(),
        (8, false) => work.run::<8, false>(),
        (12, false) => work.run::<12, false>(),
        (16, false) => work.run::<16, false>(),
        (_, false) => work.run::<MAX_WIDTH, false>(),
    }
}
