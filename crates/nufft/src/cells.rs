use pulp::{Arch, Simd, WithSimd};

use crate::error::Error;
use crate::memory::resize;
use crate::real::Real;

/// Rows and columns of a tile. Points are sorted by tile, so that consecutive points share cache
/// lines.
pub(crate) const TILE_ROWS: usize = 16;
pub(crate) const TILE_COLUMNS: usize = 64;

/// Number of points located side by side.
pub const LANES: usize = 8;

/// Angles as `eighths/8 + rest` turns, with |rest| <= 1/16. A single number would lose digits that
/// matter on a grid of thousands of cells per turn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turns {
    /// The eighths, from 0 to 8.
    pub eighths: [f64; LANES],
    /// The rest, from -1/16 to 1/16; the sum of both parts is in `[0, 1]`.
    pub rest: [f64; LANES],
}

impl Turns {
    /// Replaces entry `i` by a coordinate in `[0, 1)`, exactly.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "coordinates are in [0, 1)"
    )]
    pub(crate) fn set(&mut self, i: usize, x: f64) {
        let eighths = f64::from((8.0 * x + 0.5) as u32);
        self.eighths[i] = eighths;
        // Exact: a multiple of the last digit of x, and smaller than x or 1/16.
        self.rest[i] = x - eighths * 0.125;
    }
}

/// Points with two coordinates in turns, for the row and the column.
pub trait Places {
    /// Returns the number of points.
    fn count(&self) -> usize;

    /// Returns both coordinates of up to `LANES` points starting at index `first`. Entries beyond
    /// the last point are unused.
    ///
    /// An implementation marked `#[inline(always)]` is compiled for the selected instruction set,
    /// with fused multiply-adds if `FUSED`.
    fn turns<const FUSED: bool>(&self, first: usize) -> [Turns; 2];
}

/// Computes grid positions of points.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    /// Grid cells per full turn, for rows and for columns.
    pub(crate) cells: [usize; 2],
    /// The number of grid rows between the margins.
    pub(crate) rows: usize,
    /// The width of the window, and the number of rows and columns that it can extend before the
    /// first one.
    pub(crate) width: usize,
    pub(crate) margin: usize,
}

/// The position of a point relative to the grid.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cell<T> {
    /// The first row and column that its window touches, counted from the first row of the margin.
    pub(crate) row: u32,
    pub(crate) column: u32,
    /// Its position in the window, see
    /// [`WindowTable::evaluate`](crate::window::WindowTable::evaluate).
    pub(crate) t: [T; 2],
    pub(crate) weight: T,
    /// Its index in the caller's order.
    pub(crate) index: u32,
}

/// The points of a set sorted by tile of the grid; workspace.
#[derive(Debug, Default)]
pub struct Cells<T> {
    sorted: Vec<Cell<T>>,
    unsorted: Vec<Cell<T>>,
    tile_ends: Vec<u32>,
}

impl<T> Cells<T> {
    /// Reserves memory for a number of points, or returns an error if allocation fails.
    pub(crate) fn reserve(&mut self, n_points: usize) -> Result<(), Error>
    where
        T: Real,
    {
        resize(&mut self.sorted, n_points)?;
        resize(&mut self.unsorted, n_points)
    }

    /// Returns the points, grouped by tile.
    pub(crate) fn sorted(&self) -> &[Cell<T>] {
        &self.sorted
    }

    /// Returns the points of each tile.
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

    /// Returns the number of grid rows, including the margins.
    pub(crate) fn n_rows(&self) -> usize {
        self.rows + 2 * self.margin
    }

    /// Replaces `cells` by the points, with weights multiplied by `scale`.
    pub(crate) fn locate<T: Real, R: Real>(
        &self,
        arch: Arch,
        points: &impl Places,
        weights: Option<&[R]>,
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
            // Starts become ends as the tiles are filled.
            let place = &mut tile_ends[tile(cell)];
            sorted[*place as usize] = *cell;
            *place += 1;
        }
    }
}

struct Locate<'a, T, R, P> {
    locator: &'a Locator,
    points: &'a P,
    weights: Option<&'a [R]>,
    scale: f64,
    cells: &'a mut [Cell<T>],
}

impl<T: Real, R: Real, P: Places> WithSimd for Locate<'_, T, R, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if S::F64_LANES > 1 { self.run::<true>() } else { self.run::<false>() }
    }
}

impl<T: Real, R: Real, P: Places> Locate<'_, T, R, P> {
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
                    weight: T::of(weights.map_or(scale, |w| w[i].to_f64() * scale)),
                    index,
                };
                index += 1;
            }
        }
    }
}

impl Locator {
    /// Returns the first grid points that windows touch, and the positions of the points in their
    /// windows, along an axis of `n` cells.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "grid positions are small nonnegative numbers; NaN becomes 0"
    )]
    pub(crate) fn windows<const FUSED: bool>(
        &self,
        turns: &Turns,
        n: usize,
    ) -> ([u32; LANES], [f64; LANES]) {
        let (n, half, margin) = (n as f64, 0.5 * self.width as f64, self.margin as f64);
        let (mut first, mut t) = ([0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (base, rest) = (turns.eighths[i] * 0.125 * n, turns.rest[i] * n);
            // Rounds up by rounding down, which has an instruction on every machine; the sum is
            // positive.
            let below = (base + rest - half + margin) as u32;
            let short = f64::from(below) - margin < base + rest - half;
            let place = if short { below + 1 } else { below };
            let start = f64::from(place) - margin;
            first[i] = place;
            // The product is not rounded before the subtraction, whose result is small.
            let offset = turns.rest[i].times_plus::<FUSED>(n, base - start - half);
            t[i] = 2.0 * offset + 1.0;
        }
        (first, t)
    }
}
