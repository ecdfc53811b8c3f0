use pulp::{Simd, WithSimd};

use super::{ByWidth, Spreading, for_width};
use crate::cells::{Cell, Cells, TILE_COLUMNS, TILE_ROWS};
use crate::long_sum::{SHORT, add_with_rests};
use crate::real::Real;
use crate::window::MAX_WIDTH;

/// The grid values that the windows of a tile's points touch, row by row of `TILE_STRIDE`.
const TILE_STRIDE: usize = TILE_COLUMNS + MAX_WIDTH;
type Patch<T> = [T; TILE_STRIDE * (TILE_ROWS + MAX_WIDTH)];

/// Adds points to G grids, each with its own weights.
pub(super) struct Spread<'a, T, const G: usize> {
    pub(super) spreading: &'a Spreading<T>,
    pub(super) cells: &'a Cells<T>,
    /// In the caller's order of points; `None` means those of the cells.
    pub(super) weights: Option<&'a [[T; G]]>,
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
    fn run<const P: usize, const FUSED: bool>(self) {
        let Self { spreading, cells, weights, mut grids } = self;
        let stride = spreading.stride();
        let run = Run { spreading, weights };
        for tile in cells.tiles() {
            if tile.len() <= spreading.run {
                run.add::<P, FUSED>(tile, [0, 0], stride, &mut grids);
                continue;
            }
            // In one long sum all rounding errors can have the same sign: add in short partial sums
            // and sum these in the same way.
            let [row, column] = [tile[0].row as usize, tile[0].column as usize];
            let origin = [row / TILE_ROWS * TILE_ROWS, column / TILE_COLUMNS * TILE_COLUMNS];
            let n_rows = TILE_ROWS + spreading.table.width();
            let mut sums: [Patch<f64>; G] = [[0.0; _]; G];
            let mut blocks = tile.chunks(spreading.run * SHORT);
            run.add_in_runs::<P, FUSED>(blocks.next().unwrap_or(&[]), origin, &mut sums);
            if blocks.len() > 0 {
                let mut rests: [Patch<f64>; G] = [[0.0; _]; G];
                for block in blocks {
                    let mut more: [Patch<f64>; G] = [[0.0; _]; G];
                    run.add_in_runs::<P, FUSED>(block, origin, &mut more);
                    for ((sums, rests), more) in sums.iter_mut().zip(&mut rests).zip(&more) {
                        add_with_rests(sums, rests, more);
                    }
                }
                for (sum, rest) in sums.iter_mut().flatten().zip(rests.iter().flatten()) {
                    *sum += rest;
                }
            }
            for (grid, sums) in grids.iter_mut().zip(&sums) {
                let lines = grid.chunks_exact_mut(stride).skip(origin[0]);
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
    fn add_in_runs<const P: usize, const FUSED: bool>(
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
            self.add::<P, FUSED>(points, origin, TILE_STRIDE, &mut parts);
            for (sums, part) in sums.iter_mut().zip(&parts) {
                for (sum, part) in sums.iter_mut().zip(&**part) {
                    *sum += part.to_f64();
                }
            }
        }
    }

    /// Adds points to the parts of the grids that begin at `origin`.
    #[inline(always)]
    fn add<const P: usize, const FUSED: bool>(
        &self,
        points: &[Cell<T>],
        origin: [usize; 2],
        stride: usize,
        parts: &mut [&mut [T]; G],
    ) {
        let table = &self.spreading.table;
        let width = table.width();
        for cell in points {
            let [by_row, by_column] = table.evaluate::<P, FUSED>(cell.t);
            let [row, column] = [cell.row as usize - origin[0], cell.column as usize - origin[1]];
            let start = row * stride + column;
            let weights = self.weights.map_or([cell.weight; G], |w| w[cell.index as usize]);
            for (part, weight) in parts.iter_mut().zip(weights) {
                let Some(window) = part.get_mut(start..) else { continue };
                for (line, by_row) in window.chunks_mut(stride).zip(&by_row[..width]) {
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
