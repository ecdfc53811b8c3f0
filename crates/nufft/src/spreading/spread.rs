use pulp::{Simd, WithSimd};

use super::{ByWidth, Spreading, for_width};
use crate::cells::{Cell, Cells, TILE_COLUMNS, TILE_ROWS};
use crate::long_sum::{SHORT, add_with_rests};
use crate::real::Real;
use crate::window::MAX_WIDTH;

/// The grid values that the windows of a tile's points touch, row by row of `TILE_STRIDE`.
const TILE_STRIDE: usize = TILE_COLUMNS + MAX_WIDTH;
type Patch<T> = [T; TILE_STRIDE * (TILE_ROWS + MAX_WIDTH)];

/// Rows of a band: whole tiles, and at least the width of a window.
pub(super) const BAND_ROWS: usize = MAX_WIDTH.next_multiple_of(TILE_ROWS);

/// The points of one tile, if several threads located them.
#[derive(Debug, Default)]
pub(super) struct SpreadScratch<T> {
    joined: Vec<Cell<T>>,
}

/// Adds the points of a band of rows to G grids, each with its own weights.
pub(super) struct Spread<'a, T, const G: usize> {
    pub(super) spreading: &'a Spreading<T>,
    pub(super) cells: &'a Cells<T>,
    /// In the caller's order of points; `None` means those of the cells.
    pub(super) weights: Option<&'a [[T; G]]>,
    /// The number of the band. Bands are spread in order of their parity; an even one first sets
    /// its grids to zero.
    pub(super) band: usize,
    pub(super) scratch: &'a mut SpreadScratch<T>,
    /// The rows of the band and of the next one.
    pub(super) grids: [&'a mut [T]; G],
}

impl<T: Real, const G: usize> WithSimd for Spread<'_, T, G> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.spreading.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<T: Real, const G: usize> ByWidth for Spread<'_, T, G> {
    #[inline(always)]
    fn run<const P: usize, const H: usize, const FUSED: bool>(self) {
        let Self { spreading, cells, weights, band, scratch, mut grids } = self;
        let stride = spreading.stride();
        if band.is_multiple_of(2) {
            for grid in &mut grids {
                grid.fill(T::default());
            }
        }
        let (run, first_row) = (Run { spreading, weights }, band * BAND_ROWS);
        let (across, n_rows) = (spreading.locator.tiles_across(), spreading.locator.tile_rows());
        let first_tile = first_row / TILE_ROWS;
        let tile_rows = first_tile..n_rows.min(first_tile + BAND_ROWS / TILE_ROWS);
        for tile in tile_rows.start * across..tile_rows.end * across {
            let tile = cells.tile(tile, &mut scratch.joined);
            if tile.len() <= spreading.run {
                run.add::<P, H, FUSED>(tile, [first_row, 0], stride, &mut grids);
                continue;
            }
            // In one long sum all rounding errors can have the same sign: add in short partial sums
            // and sum these in the same way.
            let [row, column] = [tile[0].row as usize, tile[0].column as usize];
            let origin = [row / TILE_ROWS * TILE_ROWS, column / TILE_COLUMNS * TILE_COLUMNS];
            let n_rows = TILE_ROWS + spreading.table.width();
            let mut sums: [Patch<f64>; G] = [[0.0; _]; G];
            let mut blocks = tile.chunks(spreading.run * SHORT);
            run.add_in_runs::<P, H, FUSED>(blocks.next().unwrap_or(&[]), origin, &mut sums);
            if blocks.len() > 0 {
                let mut rests: [Patch<f64>; G] = [[0.0; _]; G];
                for block in blocks {
                    let mut more: [Patch<f64>; G] = [[0.0; _]; G];
                    run.add_in_runs::<P, H, FUSED>(block, origin, &mut more);
                    for ((sums, rests), more) in sums.iter_mut().zip(&mut rests).zip(&more) {
                        add_with_rests(sums, rests, more);
                    }
                }
                for (sum, rest) in sums.iter_mut().flatten().zip(rests.iter().flatten()) {
                    *sum += rest;
                }
            }
            for (grid, sums) in grids.iter_mut().zip(&sums) {
                let lines = grid.chunks_exact_mut(stride).skip(origin[0] - first_row);
                let patch = sums[..n_rows * TILE_STRIDE].chunks_exact(TILE_STRIDE);
                for (line, sums) in lines.zip(patch) {
                    for (value, &sum) in line[origin[1]..].iter_mut().zip(sums) {
                        *value += T::of(sum);
                    }
                }
            }
        }
    }
}

/// What all points of a run share.
struct Run<'a, T, const G: usize> {
    spreading: &'a Spreading<T>,
    weights: Option<&'a [[T; G]]>,
}

impl<T: Real, const G: usize> Run<'_, T, G> {
    /// Adds points to the patches of the grids that begin at `origin`, in runs with negligible
    /// rounding error.
    #[inline(always)]
    fn add_in_runs<const P: usize, const H: usize, const FUSED: bool>(
        &self,
        points: &[Cell<T>],
        origin: [usize; 2],
        sums: &mut [Patch<f64>; G],
    ) {
        let mut parts: [Patch<T>; G] = [[T::default(); _]; G];
        let len = (TILE_ROWS + self.spreading.table.width()) * TILE_STRIDE;
        let mut parts = parts.each_mut().map(|part| &mut part[..len]);
        for points in points.chunks(self.spreading.run) {
            for part in &mut parts {
                part.fill(T::default());
            }
            self.add::<P, H, FUSED>(points, origin, TILE_STRIDE, &mut parts);
            for (sums, part) in sums.iter_mut().zip(&parts) {
                for (sum, part) in sums.iter_mut().zip(&**part) {
                    *sum += part.to_f64();
                }
            }
        }
    }

    /// Adds points to the parts of the grids that begin at `origin`.
    #[inline(always)]
    fn add<const P: usize, const H: usize, const FUSED: bool>(
        &self,
        points: &[Cell<T>],
        origin: [usize; 2],
        stride: usize,
        parts: &mut [&mut [T]; G],
    ) {
        let table = &self.spreading.table;
        let rows = table.rows();
        for cell in points {
            let [by_row, by_column] = table.evaluate::<P, H, FUSED>(cell.t);
            let [row, column] = [cell.row as usize - origin[0], cell.column as usize - origin[1]];
            let start = row * stride + column;
            let weights = self.weights.map_or([cell.weight; G], |w| w[cell.index as usize]);
            for (part, weight) in parts.iter_mut().zip(weights) {
                let Some(window) = part.get_mut(start..) else { continue };
                for (line, by_row) in window.chunks_mut(stride).zip(&by_row[rows.clone()]) {
                    let factor = *by_row * weight;
                    if let Some(line) = line.first_chunk_mut::<P>() {
                        for i in 0..P {
                            line[i] = by_column[i].times_plus::<FUSED>(factor, line[i]);
                        }
                    }
                }
            }
        }
    }
}
