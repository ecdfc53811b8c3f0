use pulp::{Arch, Simd, WithSimd};

use crate::error::Error;
use crate::memory::resize;
use crate::real::Real;
use crate::threads::{Threads, share};
use crate::window::WindowTable;

/// Rows and columns of a tile. Points are sorted by tile, so that consecutive points share cache
/// lines.
pub(crate) const TILE_ROWS: usize = 16;
pub(crate) const TILE_COLUMNS: usize = 64;

/// The minimum number of points that are worth a part of their own.
const MIN_PART: usize = 4096;

/// Number of parts for each thread, so that an idle thread finds one.
const PARTS_PER_THREAD: usize = 4;

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
pub trait Places: Sync {
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
    /// first one, padding included.
    pub(crate) width: usize,
    pub(crate) margin: usize,
    /// The number of columns that padding adds before a window.
    pad: u32,
}

/// The position of a point relative to the grid.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cell<T> {
    /// The first row that its window touches and the first column, padding included, counted from
    /// the first of the margin.
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
///
/// Several threads sort consecutive parts of the points. Within a tile, points are in the caller's
/// order for any number of parts.
#[derive(Debug, Default)]
pub struct Cells<T> {
    /// The first `used` are of this set.
    parts: Vec<Part<T>>,
    used: usize,
    /// The number of points of each part but the last.
    part_len: usize,
}

/// Consecutive points sorted by tile.
#[derive(Debug, Default)]
pub(crate) struct Part<T> {
    /// The index of its first point.
    pub(crate) first: usize,
    pub(crate) sorted: Vec<Cell<T>>,
    unsorted: Vec<Cell<T>>,
    tile_ends: Vec<u32>,
}

impl<T> Cells<T> {
    /// Reserves memory for a number of points, or returns an error if allocation fails.
    pub(crate) fn reserve(&mut self, n_points: usize, threads: Threads) -> Result<(), Error>
    where
        T: Real,
    {
        self.split(n_points, threads);
        for part in &mut self.parts[..self.used] {
            let len = self.part_len.min(n_points - part.first);
            resize(&mut part.sorted, len)?;
            resize(&mut part.unsorted, len)?;
        }
        Ok(())
    }

    /// Determines the parts of a number of points.
    fn split(&mut self, n_points: usize, threads: Threads)
    where
        T: Real,
    {
        let count = match threads.count() {
            1 => 1,
            threads => (n_points / MIN_PART).clamp(1, threads * PARTS_PER_THREAD),
        };
        self.part_len = n_points.div_ceil(count).next_multiple_of(LANES);
        self.used = n_points.div_ceil(self.part_len.max(1)).max(1);
        if self.parts.len() < self.used {
            self.parts.resize_with(self.used, Part::default);
        }
        for (i, part) in self.parts[..self.used].iter_mut().enumerate() {
            part.first = i * self.part_len;
        }
    }

    /// Returns the parts.
    pub(crate) fn parts(&self) -> &[Part<T>] {
        &self.parts[..self.used]
    }

    /// Returns the number of points of each part but the last.
    pub(crate) fn part_len(&self) -> usize {
        self.part_len
    }

    /// Returns the points of a tile, which are copied to `joined` if several parts have some.
    pub(crate) fn tile<'a>(&'a self, tile: usize, joined: &'a mut Vec<Cell<T>>) -> &'a [Cell<T>]
    where
        T: Real,
    {
        let mut parts = self.parts().iter().map(|part| part.tile(tile)).filter(|t| !t.is_empty());
        let first = parts.next().unwrap_or(&[]);
        let Some(second) = parts.next() else { return first };
        joined.clear();
        joined.extend_from_slice(first);
        joined.extend_from_slice(second);
        for more in parts {
            joined.extend_from_slice(more);
        }
        joined
    }
}

impl<T> Part<T> {
    fn tile(&self, tile: usize) -> &[Cell<T>] {
        let start = tile.checked_sub(1).map_or(0, |before| self.tile_ends[before] as usize);
        &self.sorted[start..self.tile_ends[tile] as usize]
    }
}

impl Locator {
    pub(crate) fn new<T: Real>(cells: [usize; 2], rows: usize, table: &WindowTable<T>) -> Self {
        // The padding of a window must not extend before the first column.
        let margin = table.padded() / 2 + 1;
        Self { cells, rows, width: table.width(), margin, pad: index_of(table.pad()) }
    }

    /// Returns the number of grid rows, including the margins.
    pub(crate) fn n_rows(&self) -> usize {
        self.rows + 2 * self.margin
    }

    /// Returns the number of tiles side by side.
    pub(crate) fn tiles_across(&self) -> usize {
        self.cells[1] / TILE_COLUMNS + 1
    }

    /// Returns the number of rows of tiles.
    pub(crate) fn tile_rows(&self) -> usize {
        self.n_rows() / TILE_ROWS + 1
    }

    /// Replaces `cells` by the points, with weights multiplied by `scale`.
    pub(crate) fn locate<T: Real, R: Real>(
        &self,
        arch: Arch,
        points: &impl Places,
        weights: Option<&[R]>,
        scale: f64,
        threads: Threads,
        cells: &mut Cells<T>,
    ) {
        let count = points.count();
        cells.split(count, threads);
        let len = cells.part_len;
        let parts = cells.parts[..cells.used].iter_mut();
        share(&mut vec![(); threads.count()], parts, |(), part| {
            let Part { first, sorted, unsorted, tile_ends } = part;
            unsorted.resize(len.min(count - *first), Cell::default());
            let locate = Locate { locator: self, points, weights, scale, first: *first, unsorted };
            arch.dispatch(locate);
            self.sort(unsorted, tile_ends, sorted);
        });
    }

    /// Sorts points by tile, in their order within a tile.
    fn sort<T: Real>(
        &self,
        unsorted: &[Cell<T>],
        tile_ends: &mut Vec<u32>,
        sorted: &mut Vec<Cell<T>>,
    ) {
        let across = self.tiles_across();
        let tile =
            |c: &Cell<T>| c.row as usize / TILE_ROWS * across + c.column as usize / TILE_COLUMNS;
        // A counting sort.
        tile_ends.clear();
        tile_ends.resize(self.tile_rows() * across, 0);
        for cell in unsorted {
            tile_ends[tile(cell)] += 1;
        }
        let mut sum = 0;
        for end in &mut *tile_ends {
            sum += std::mem::replace(end, sum);
        }
        sorted.resize(unsorted.len(), Cell::default());
        for cell in unsorted {
            // Starts become ends as the tiles are filled.
            let place = &mut tile_ends[tile(cell)];
            sorted[*place as usize] = *cell;
            *place += 1;
        }
    }
}

/// Numbers of this size have integer spacing.
const TWO_TO_52: f64 = (1u64 << 52) as f64;

struct Locate<'a, T, R, P> {
    locator: &'a Locator,
    points: &'a P,
    weights: Option<&'a [R]>,
    scale: f64,
    /// The index of the first of the points to locate.
    first: usize,
    unsorted: &'a mut [Cell<T>],
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
        let Self { locator, points, weights, scale, first, unsorted } = self;
        for (first, cells) in (first..).step_by(LANES).zip(unsorted.chunks_mut(LANES)) {
            let [u, v] = points.turns::<FUSED>(first);
            let (rows, t_u) = locator.windows::<FUSED>(&u, locator.cells[0]);
            let (columns, t_v) = locator.windows::<FUSED>(&v, locator.cells[1]);
            let weights = weights.map(|w| &w[first..]);
            for (index, (i, cell)) in (index_of(first)..).zip(cells.iter_mut().enumerate()) {
                *cell = Cell {
                    row: rows[i],
                    // An invalid point is at 0.
                    column: columns[i].saturating_sub(locator.pad),
                    t: [T::of(t_u[i]), T::of(t_v[i])],
                    weight: T::of(weights.map_or(scale, |w| w[i].to_f64() * scale)),
                    index,
                };
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
            // Rounds up by rounding down. The sum is positive, or NaN, which becomes 0.
            let position = base + rest - half + margin;
            let position = if position > 0.0 { position } else { 0.0 };
            // Rounding has an instruction wherever there are fused multiply-adds, and conversion
            // to an integer elsewhere.
            let below = if FUSED { position.floor() } else { f64::from(position as u32) };
            let short = below - margin < base + rest - half;
            let place = if short { below + 1.0 } else { below };
            let start = place - margin;
            // The last digits of the sum are the integer, without a conversion of one number at a
            // time.
            first[i] = (place + TWO_TO_52).to_bits() as u32;
            // The product is not rounded before the subtraction, whose result is small.
            let offset = turns.rest[i].times_plus::<FUSED>(n, base - start - half);
            t[i] = 2.0 * offset + 1.0;
        }
        (first, t)
    }
}

/// Returns an index as it is stored.
#[expect(clippy::cast_possible_truncation, reason = "sets have fewer than 2^32 points")]
#[inline(always)]
fn index_of(i: usize) -> u32 {
    i as u32
}
