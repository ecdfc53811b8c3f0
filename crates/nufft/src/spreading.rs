use pulp::{Arch, Simd, WithSimd};

use crate::cells::{Cell, Cells, Locator, Places, TILE_COLUMNS, TILE_ROWS};
use crate::long_sum::{SHORT, add_with_rests};
use crate::real::Real;
use crate::window::{MAX_WIDTH, Window, WindowTable};

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

/// The grid values that the windows of a tile's points touch, row by row of `TILE_STRIDE`.
const TILE_STRIDE: usize = TILE_COLUMNS + MAX_WIDTH;
type Patch<T> = [T; TILE_STRIDE * (TILE_ROWS + MAX_WIDTH)];

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
    pub fn locate(
        &self,
        arch: Arch,
        points: &impl Places,
        weights: Option<&[f64]>,
        scale: f64,
        cells: &mut Cells<T>,
    ) {
        self.locator.locate(arch, points, weights, scale, cells);
    }

    /// Adds the points to the grid.
    pub fn spread(&self, arch: Arch, cells: &Cells<T>, grid: &mut [T]) {
        arch.dispatch(Spread { spreading: self, cells, grid });
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
        out: &mut [f64],
    ) {
        arch.dispatch(Interpolate { spreading: self, cells: cells.sorted(), grids, sizes, out });
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

struct Spread<'a, T> {
    spreading: &'a Spreading<T>,
    cells: &'a Cells<T>,
    grid: &'a mut [T],
}

impl<T: Real> WithSimd for Spread<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.spreading.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<T: Real> ByWidth for Spread<'_, T> {
    #[inline(always)]
    fn run<const P: usize, const FUSED: bool>(self) {
        let Self { spreading, cells, grid } = self;
        let stride = spreading.stride();
        for tile in cells.tiles() {
            if tile.len() <= spreading.run {
                spreading.add::<P, FUSED>(tile, [0, 0], stride, grid);
                continue;
            }
            // In one long sum all rounding errors can have the same sign: add in short partial sums
            // and sum these in the same way.
            let [row, column] = [tile[0].row as usize, tile[0].column as usize];
            let origin = [row / TILE_ROWS * TILE_ROWS, column / TILE_COLUMNS * TILE_COLUMNS];
            let n_rows = TILE_ROWS + spreading.table.width();
            let mut sums: Patch<f64> = [0.0; _];
            let mut blocks = tile.chunks(spreading.run * SHORT);
            spreading.add_in_runs::<P, FUSED>(blocks.next().unwrap_or(&[]), origin, &mut sums);
            if blocks.len() > 0 {
                let mut rests: Patch<f64> = [0.0; _];
                for block in blocks {
                    let mut more: Patch<f64> = [0.0; _];
                    spreading.add_in_runs::<P, FUSED>(block, origin, &mut more);
                    add_with_rests(&mut sums, &mut rests, &more);
                }
                for (sum, rest) in sums.iter_mut().zip(&rests) {
                    *sum += rest;
                }
            }
            let lines = grid.chunks_exact_mut(stride).skip(origin[0]);
            for (line, sums) in lines.zip(sums[..n_rows * TILE_STRIDE].chunks_exact(TILE_STRIDE)) {
                for (value, &sum) in line[origin[1]..].iter_mut().zip(sums) {
                    *value += T::of(sum);
                }
            }
        }
    }
}

impl<T: Real> Spreading<T> {
    /// Adds points to the patch of the grid that begins at `origin`, in runs with negligible
    /// rounding error.
    #[inline(always)]
    fn add_in_runs<const P: usize, const FUSED: bool>(
        &self,
        points: &[Cell<T>],
        origin: [usize; 2],
        sums: &mut Patch<f64>,
    ) {
        let mut part: Patch<T> = [T::default(); _];
        let part = &mut part[..(TILE_ROWS + self.table.width()) * TILE_STRIDE];
        for points in points.chunks(self.run) {
            part.fill(T::default());
            self.add::<P, FUSED>(points, origin, TILE_STRIDE, part);
            for (sum, part) in sums.iter_mut().zip(&*part) {
                *sum += part.to_f64();
            }
        }
    }

    /// Adds points to the part of the grid that begins at `origin`.
    #[inline(always)]
    fn add<const P: usize, const FUSED: bool>(
        &self,
        points: &[Cell<T>],
        origin: [usize; 2],
        stride: usize,
        part: &mut [T],
    ) {
        let width = self.table.width();
        for cell in points {
            let [by_row, by_column] = self.table.evaluate::<P, FUSED>(cell.t);
            let [row, column] = [cell.row as usize - origin[0], cell.column as usize - origin[1]];
            let Some(window) = part.get_mut(row * stride + column..) else { continue };
            for (line, by_row) in window.chunks_mut(stride).zip(&by_row[..width]) {
                let factor = *by_row * cell.weight;
                if let Some(line) = line.first_chunk_mut::<P>() {
                    for i in 0..P {
                        line[i] = by_column[i].times_plus::<FUSED>(factor, line[i]);
                    }
                }
            }
        }
    }
}

struct Interpolate<'a, T> {
    spreading: &'a Spreading<T>,
    cells: &'a [Cell<T>],
    grids: &'a [T],
    sizes: &'a [f64],
    out: &'a mut [f64],
}

impl<T: Real> WithSimd for Interpolate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.spreading.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<T: Real> ByWidth for Interpolate<'_, T> {
    #[inline(always)]
    fn run<const P: usize, const FUSED: bool>(self) {
        let Self { spreading, cells, grids, sizes, out } = self;
        let (width, stride) = (spreading.table.width(), spreading.stride());
        let size = spreading.grid_len();
        for cell in cells {
            let [by_row, by_column] = spreading.table.evaluate::<P, FUSED>(cell.t);
            let start = cell.row as usize * stride + cell.column as usize;
            let values = &mut out[cell.index as usize * sizes.len()..][..sizes.len()];
            let functions = grids.chunks_exact(size).zip(sizes);
            for (value, (grid, scale)) in values.iter_mut().zip(functions) {
                let Some(window) = grid.get(start..) else { continue };
                let mut sums = [T::default(); P];
                for (line, by_row) in window.chunks(stride).zip(&by_row[..width]) {
                    if let Some(line) = line.first_chunk::<P>() {
                        for i in 0..P {
                            sums[i] = line[i].times_plus::<FUSED>(*by_row, sums[i]);
                        }
                    }
                }
                let products = sums.iter().zip(&by_column).map(|(s, w)| *s * *w);
                *value = products.fold(T::default(), |sum, p| sum + p).to_f64() * scale;
            }
        }
    }
}
