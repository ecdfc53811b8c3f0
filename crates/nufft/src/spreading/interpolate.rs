use pulp::{Simd, WithSimd};

use super::{ByWidth, Spreading, for_width};
use crate::cells::Part;
use crate::real::Real;

/// Values of several functions at the points of a part, with those of its first point at the start of `out`.
pub(super) struct Interpolate<'a, T, R> {
    pub(super) spreading: &'a Spreading<T>,
    pub(super) part: &'a Part<T>,
    pub(super) grids: &'a [T],
    pub(super) sizes: &'a [f64],
    pub(super) out: &'a mut [R],
}

impl<T: Real, R: Real> WithSimd for Interpolate<'_, T, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.spreading.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<T: Real, R: Real> ByWidth for Interpolate<'_, T, R> {
    #[inline(always)]
    fn run<const P: usize, const H: usize, const FUSED: bool>(self) {
        let Self { spreading, part, grids, sizes, out } = self;
        let stride = spreading.stride();
        let rows = spreading.table.rows();
        let size = spreading.grid_len();
        for cell in &part.sorted {
            let [by_row, by_column] = spreading.table.evaluate::<P, H, FUSED>(cell.t);
            let start = cell.row as usize * stride + cell.column as usize;
            let values =
                &mut out[(cell.index as usize - part.first) * sizes.len()..][..sizes.len()];
            let functions = grids.chunks_exact(size).zip(sizes);
            for (value, (grid, scale)) in values.iter_mut().zip(functions) {
                let Some(window) = grid.get(start..) else { continue };
                let mut sums = [T::default(); P];
                for (line, by_row) in window.chunks(stride).zip(&by_row[rows.clone()]) {
                    if let Some(line) = line.first_chunk::<P>() {
                        for i in 0..P {
                            sums[i] = line[i].times_plus::<FUSED>(*by_row, sums[i]);
                        }
                    }
                }
                *value = R::of(dot(&sums, &by_column).to_f64() * scale);
            }
        }
    }
}

/// The value of a function and its derivatives by both coordinates, per turn, at points.
pub(super) struct InterpolateGradient<'a, T, R> {
    pub(super) spreading: &'a Spreading<T>,
    pub(super) part: &'a Part<T>,
    pub(super) grid: &'a [T],
    pub(super) size: f64,
    pub(super) out: &'a mut [[R; 3]],
}

impl<T: Real, R: Real> WithSimd for InterpolateGradient<'_, T, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.spreading.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<T: Real, R: Real> ByWidth for InterpolateGradient<'_, T, R> {
    #[inline(always)]
    fn run<const P: usize, const H: usize, const FUSED: bool>(self) {
        let Self { spreading, part, grid, size, out } = self;
        let stride = spreading.stride();
        let rows = spreading.table.rows();
        // A position in the window moves by 2 for each cell.
        let per_turn = spreading.locator.cells.map(|cells| 2.0 * cells as f64 * size);
        for cell in &part.sorted {
            let [by_row, by_column] = spreading.table.evaluate_with_slope::<P, H, FUSED>(cell.t);
            let start = cell.row as usize * stride + cell.column as usize;
            let Some(window) = grid.get(start..) else { continue };
            let (mut sums, mut slopes) = ([T::default(); P], [T::default(); P]);
            let [row_values, row_slopes] = by_row.each_ref().map(|by_row| &by_row[rows.clone()]);
            for ((line, value), slope) in window.chunks(stride).zip(row_values).zip(row_slopes) {
                if let Some(line) = line.first_chunk::<P>() {
                    for i in 0..P {
                        sums[i] = line[i].times_plus::<FUSED>(*value, sums[i]);
                        slopes[i] = line[i].times_plus::<FUSED>(*slope, slopes[i]);
                    }
                }
            }
            let [column_values, column_slopes] = &by_column;
            out[cell.index as usize - part.first] = [
                R::of(dot(&sums, column_values).to_f64() * size),
                R::of(dot(&slopes, column_values).to_f64() * per_turn[0]),
                R::of(dot(&sums, column_slopes).to_f64() * per_turn[1]),
            ];
        }
    }
}

#[inline(always)]
fn dot<T: Real, const P: usize>(a: &[T; P], b: &[T; P]) -> T {
    a.iter().zip(b).map(|(a, b)| *a * *b).fold(T::default(), |sum, product| sum + product)
}
