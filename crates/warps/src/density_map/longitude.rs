//! The conditional density over columns at a colatitude.

use super::guide::{bracket, last_interval, write_guide};
use super::sampling::index_of;
use crate::newton::linear_root;

/// Number of cells between stored sums: two cache lines, and a sixteenth of the memory of texels.
pub(super) const BLOCK: usize = 16;

/// A row of texels with its sums over cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'a> {
    pub(super) texels: &'a [f64],
    /// The sums of the cells before each block, and of all.
    pub(super) sums: &'a [f64],
    /// The blocks at equidistant fractions of the sum.
    pub(super) guide: &'a [u32],
    /// Whether cells lie between the centres of texels instead of between their edges.
    pub(super) is_bilinear: bool,
}

impl Row<'_> {
    /// Returns the values at both ends of a cell.
    #[inline]
    pub(super) fn ends(&self, cell: usize) -> [f64; 2] {
        let first = self.texels[cell];
        let next = if cell + 1 < self.texels.len() { cell + 1 } else { 0 };
        [first, if self.is_bilinear { self.texels[next] } else { first }]
    }

    /// Returns the integral over a cell of width 1.
    #[inline]
    pub(super) fn cell(&self, cell: usize) -> f64 {
        let [first, last] = self.ends(cell);
        0.5 * (first + last)
    }

    /// Returns the mean of the row.
    pub(super) fn mean(&self) -> f64 {
        self.sums[self.sums.len() - 1] / self.texels.len() as f64
    }

    /// Writes the sums before each block of cells, and the total, and the guide.
    pub(super) fn write_sums(
        texels: &[f64],
        is_bilinear: bool,
        sums: &mut [f64],
        guide: &mut [u32],
    ) {
        let row = Row { texels, sums: &[], guide: &[], is_bilinear };
        let mut sum = 0.0;
        for cell in 0..texels.len() {
            if cell % BLOCK == 0 {
                sums[cell / BLOCK] = sum;
            }
            sum += row.cell(cell);
        }
        if let Some(total) = sums.last_mut() {
            *total = sum;
        }
        write_guide(sums, guide);
    }
}

/// The density over columns at a colatitude, `sum_i factor_i row_i + floor`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns<'a> {
    pub(super) rows: [Row<'a>; 2],
    pub(super) factors: [f64; 2],
    pub(super) floor: f64,
}

impl Columns<'_> {
    fn len(&self) -> usize {
        self.rows[0].texels.len()
    }

    #[inline]
    fn combine(&self, [first, second]: [f64; 2], cells: usize) -> f64 {
        self.factors[0] * first + self.factors[1] * second + self.floor * cells as f64
    }

    /// Returns the integral before a block; the last index is that of all cells.
    fn before_block(&self, block: usize) -> f64 {
        let cells = (block * BLOCK).min(self.len());
        self.combine(self.rows.map(|row| row.sums[block]), cells)
    }

    /// Returns the values at both ends of a cell.
    fn ends(&self, cell: usize) -> [f64; 2] {
        let [a, b] = self.rows.map(|row| row.ends(cell));
        [0, 1].map(|end| self.factors[0] * a[end] + self.factors[1] * b[end] + self.floor)
    }

    /// Returns the value at `x` in [0, 1] of a cell.
    pub(super) fn value(&self, cell: usize, x: f64) -> f64 {
        let [first, last] = self.ends(cell);
        first + (last - first) * x
    }

    /// Returns the cell, the place in it, and the density there, of a fraction v of the integral.
    ///
    /// A search of blocks, then the sums of at most [`BLOCK`] cells: each sum is the one that was
    /// stored, so the map is monotone across blocks.
    pub(super) fn find(&self, v: f64) -> (usize, f64, f64) {
        let blocks = self.rows[0].sums.len() - 1;
        let total = self.before_block(blocks);
        if total <= 0.0 {
            // A row of zeros at the edge of its band, a set of measure 0.
            return (0, v, 0.0);
        }
        // Below the total there is a cell with a positive integral.
        let target = (v * total).min(total.next_down());
        let low = last_interval(blocks, self.bracket(v), target, |block| self.before_block(block));
        let mut sums = self.rows.map(|row| row.sums[low]);
        let mut cell = low * BLOCK;
        let mut before = self.combine(sums, cell);
        let end = (cell + BLOCK).min(self.len()) - 1;
        while cell < end {
            for (sum, row) in sums.iter_mut().zip(&self.rows) {
                *sum += row.cell(cell);
            }
            let after = self.combine(sums, cell + 1);
            if after > target {
                break;
            }
            before = after;
            cell += 1;
        }
        let [first, last] = self.ends(cell);
        let x = linear_root(first, last, target - before);
        (cell, x, first + (last - first) * x)
    }

    /// Returns a bracket of the block at a fraction v: quantiles of a mixture are between those of
    /// its components.
    fn bracket(&self, v: f64) -> [usize; 2] {
        let [mut low, mut high] = [usize::MAX, 0];
        let mut include = |[first, end]: [usize; 2]| {
            low = low.min(first);
            high = high.max(end);
        };
        for (row, factor) in self.rows.iter().zip(self.factors) {
            if factor * row.sums[row.sums.len() - 1] > 0.0 {
                include(bracket(row.guide, v));
            }
        }
        if self.floor > 0.0 {
            let block = index_of(v * self.len() as f64, self.len()) / BLOCK;
            include([block, block + 1]);
        }
        // Products with a factor may underflow, and the sum not.
        if low < high { [low, high] } else { [0, self.rows[0].guide.len()] }
    }

    /// Returns the fraction of the integral before `x` in [0, 1] of a cell.
    pub(super) fn fraction(&self, cell: usize, x: f64) -> f64 {
        let block = cell / BLOCK;
        let mut sums = self.rows.map(|row| row.sums[block]);
        for before in block * BLOCK..cell {
            for (sum, row) in sums.iter_mut().zip(&self.rows) {
                *sum += row.cell(before);
            }
        }
        let [first, last] = self.ends(cell);
        let inside = x * (first + 0.5 * (last - first) * x);
        let total = self.before_block(self.rows[0].sums.len() - 1);
        (self.combine(sums, cell) + inside) / total
    }

    /// Returns the fractions at the edges between cells.
    pub(super) fn edges(&self) -> Vec<f64> {
        let total = self.before_block(self.rows[0].sums.len() - 1);
        let mut sums = [0.0; 2];
        let mut edges = Vec::with_capacity(self.len());
        for cell in 0..self.len() {
            edges.push(self.combine(sums, cell) / total);
            for (sum, row) in sums.iter_mut().zip(&self.rows) {
                *sum += row.cell(cell);
            }
        }
        edges
    }
}
