use pulp::{Arch, Simd, WithSimd};

use crate::error::Error;
use crate::memory::resize;
use crate::real::Real;

/// Rows and columns of the grid that points are gathered by, so that those treated in succession
/// share the memory nearest to the processor.
pub(crate) const TILE_ROWS: usize = 16;
pub(crate) const TILE_COLUMNS: usize = 64;

/// Points that are located side by side.
pub const LANES: usize = 8;

/// Angles as `eighths/8 + rest` turns, with |rest| <= 1/16: in two parts because a sum would round
/// away what a grid of thousands of cells to a turn can see.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turns {
    /// From 0 to 8.
    pub eighths: [f64; LANES],
    /// From -1/16 to 1/16; the sum of both parts is in `[0, 1]`.
    pub rest: [f64; LANES],
}

/// Points with two coordinates in turns, the row's and the column's.
pub trait Places {
    /// Returns the number of points.
    fn count(&self) -> usize;

    /// Returns both coordinates of the points from number `first` on; what is beyond the last is
    /// not used.
    ///
    /// Compiled for the instruction set at hand if it is `#[inline(always)]`, with fused
    /// multiply-adds if `FUSED`.
    fn turns<const FUSED: bool>(&self, first: usize) -> [Turns; 2];
}

/// How points find their place on the grid.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    /// Grid cells to a full turn, by row and by column.
    pub(crate) cells: [usize; 2],
    /// Rows that the grid has between its margins.
    pub(crate) rows: usize,
    /// The width of the window, and the rows and columns that it can reach beyond the first.
    pub(crate) width: usize,
    pub(crate) margin: usize,
}

/// A point as the window sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cell<T> {
    /// The first row and column that its window touches, counted from the first of the margin.
    pub(crate) row: u32,
    pub(crate) column: u32,
    /// Its place in the window, see
    /// [`WindowTable::evaluate`](crate::window::WindowTable::evaluate).
    pub(crate) t: [T; 2],
    pub(crate) weight: T,
    /// Its number in the caller's order.
    pub(crate) index: u32,
}

/// The points of a set by tile of the grid; scratch memory.
#[derive(Debug, Default)]
pub struct Cells<T> {
    sorted: Vec<Cell<T>>,
    unsorted: Vec<Cell<T>>,
    tile_ends: Vec<u32>,
}

impl<T> Cells<T> {
    /// Makes room for a number of points, or returns an error if the memory is unavailable.
    pub(crate) fn reserve(&mut self, n_points: usize) -> Result<(), Error>
    where
        T: Real,
    {
        resize(&mut self.sorted, n_points)?;
        resize(&mut self.unsorted, n_points)
    }

    /// The points, those of a tile after one another.
    pub(crate) fn sorted(&self) -> &[Cell<T>] {
        &self.sorted
    }

    /// The points of each tile in turn.
    pub(crate) fn tiles(&self) -> impl Iterator<Item = &[Cell<T>]> {
        let mut start = 0;
        self.tile_ends.iter().map(move |&end| {
            let tile = &self.sorted[start..end as usize];
            start = end as usize;
            tile
        })
    }
}

impl Locator {
    pub(crate) fn new(cells: [usize; 2], rows: usize, width: usize) -> Self {
        Self { cells, rows, width, margin: width / 2 + 1 }
    }

    /// Rows of the grid, the margins included.
    pub(crate) fn n_rows(&self) -> usize {
        self.rows + 2 * self.margin
    }

    /// Replaces `cells` by the points, weights multiplied by `scale`.
    pub(crate) fn locate<T: Real>(
        &self,
        arch: Arch,
        points: &impl Places,
        weights: Option<&[f64]>,
        scale: f64,
        cells: &mut Cells<T>,
    ) {
        let Cells { sorted, unsorted, tile_ends } = cells;
        unsorted.clear();
        unsorted.resize(points.count(), Cell::default());
        arch.dispatch(Locate { locator: self, points, weights, scale, cells: unsorted });
        let across = self.cells[1] / TILE_COLUMNS + 1;
        let tile =
            |c: &Cell<T>| c.row as usize / TILE_ROWS * across + c.column as usize / TILE_COLUMNS;
        // A counting sort.
        tile_ends.clear();
        tile_ends.resize((self.n_rows() / TILE_ROWS + 1) * across, 0);
        for cell in &*unsorted {
            tile_ends[tile(cell)] += 1;
        }
        let mut sum = 0;
        for end in &mut *tile_ends {
            sum += std::mem::replace(end, sum);
        }
        sorted.resize(unsorted.len(), Cell::default());
        for cell in &*unsorted {
            // Starts become ends while the tiles fill up.
            let place = &mut tile_ends[tile(cell)];
            sorted[*place as usize] = *cell;
            *place += 1;
        }
    }
}

struct Locate<'a, T, P> {
    locator: &'a Locator,
    points: &'a P,
    weights: Option<&'a [f64]>,
    scale: f64,
    cells: &'a mut [Cell<T>],
}

impl<T: Real, P: Places> WithSimd for Locate<'_, T, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if S::F64_LANES > 1 { self.run::<true>() } else { self.run::<false>() }
    }
}

impl<T: Real, P: Places> Locate<'_, T, P> {
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { locator, points, weights, scale, cells } = self;
        let mut index = 0;
        for (chunk, cells) in cells.chunks_mut(LANES).enumerate() {
            let [u, v] = points.turns::<FUSED>(chunk * LANES);
            let (rows, t_u) = locator.windows::<FUSED>(&u, locator.cells[0]);
            let (columns, t_v) = locator.windows::<FUSED>(&v, locator.cells[1]);
            let weights = weights.map(|w| &w[chunk * LANES..]);
            for (i, cell) in cells.iter_mut().enumerate() {
                *cell = Cell {
                    row: rows[i],
                    column: columns[i],
                    t: [T::of(t_u[i]), T::of(t_v[i])],
                    weight: T::of(weights.map_or(scale, |w| w[i] * scale)),
                    index,
                };
                index += 1;
            }
        }
    }
}

impl Locator {
    /// The first places that windows touch, and the points in them, along an axis of `n` cells.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "places on the grid are small numbers from 0 on; NaN becomes 0"
    )]
    fn windows<const FUSED: bool>(&self, turns: &Turns, n: usize) -> ([u32; LANES], [f64; LANES]) {
        let (n, half, margin) = (n as f64, 0.5 * self.width as f64, self.margin as f64);
        let (mut first, mut t) = ([0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (base, rest) = (turns.eighths[i] * 0.125 * n, turns.rest[i] * n);
            // Rounding up by rounding down, which has an instruction on every machine: the sum is
            // positive.
            let below = (base + rest - half + margin) as u32;
            let short = f64::from(below) - margin < base + rest - half;
            let place = if short { below + 1 } else { below };
            let start = f64::from(place) - margin;
            first[i] = place;
            // The product is not rounded before the difference, which is small.
            let offset = turns.rest[i].times_plus::<FUSED>(n, base - start - half);
            t[i] = 2.0 * offset + 1.0;
        }
        (first, t)
    }
}
