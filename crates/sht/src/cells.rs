use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::angles::{self, Angles};
use crate::real::Real;

/// Rows and columns of the grid that points are gathered by, so that those treated in succession
/// share the memory nearest to the processor.
pub(crate) const TILE_ROWS: usize = 16;
pub(crate) const TILE_COLUMNS: usize = 64;

/// How points find their place on the grid: theta from 0 to pi in rows, phi in columns.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    angles: Angles,
    /// Grid cells to a full turn.
    pub(crate) n_theta: usize,
    pub(crate) n_phi: usize,
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
    /// Its place in the window, see [`WindowTable::evaluate`](crate::window::WindowTable::evaluate).
    pub(crate) t: [T; 2],
    pub(crate) weight: T,
    /// Its number in the caller's order.
    pub(crate) index: u32,
}

/// The points of a set by tile of the grid; scratch memory.
#[derive(Debug, Default)]
pub(crate) struct Cells<T> {
    sorted: Vec<Cell<T>>,
    unsorted: Vec<Cell<T>>,
    tile_ends: Vec<u32>,
}

impl<T> Cells<T> {
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
    pub(crate) fn new(n_theta: usize, n_phi: usize, width: usize) -> Self {
        Self { angles: Angles::new(), n_theta, n_phi, width, margin: width / 2 + 1 }
    }

    /// Rows of the grid: theta from 0 to pi, and the margins beyond the poles.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_theta / 2 + 1 + 2 * self.margin
    }

    /// Replaces `cells` by the points, weights multiplied by `scale`.
    pub(crate) fn locate<T: Real>(
        &self,
        arch: Arch,
        points: &[DVec3],
        weights: Option<&[f64]>,
        scale: f64,
        cells: &mut Cells<T>,
    ) {
        let Cells { sorted, unsorted, tile_ends } = cells;
        unsorted.clear();
        unsorted.resize(points.len(), Cell::default());
        arch.dispatch(Locate { locator: self, points, weights, scale, cells: unsorted });
        let across = self.n_phi / TILE_COLUMNS + 1;
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

struct Locate<'a, T> {
    locator: &'a Locator,
    points: &'a [DVec3],
    weights: Option<&'a [f64]>,
    scale: f64,
    cells: &'a mut [Cell<T>],
}

impl<T: Real> WithSimd for Locate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if S::F64_LANES > 1 { self.run::<true>() } else { self.run::<false>() }
    }
}

impl<T: Real> Locate<'_, T> {
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "places on the grid are small numbers from 0 on; NaN becomes 0"
    )]
    fn run<const FUSED: bool>(self) {
        let Self { locator, points, weights, scale, cells } = self;
        let half = 0.5 * locator.width as f64;
        let margin = locator.margin as f64;
        let mut index = 0;
        for (chunk, (points, cells)) in
            points.chunks(angles::WIDTH).zip(cells.chunks_mut(angles::WIDTH)).enumerate()
        {
            let mut coordinates = [[0.0; angles::WIDTH]; 3];
            for (i, p) in points.iter().enumerate() {
                (coordinates[0][i], coordinates[1][i], coordinates[2][i]) = (p.x, p.y, p.z);
            }
            let [x, y, z] = coordinates;
            let mut rho = [0.0; angles::WIDTH];
            for i in 0..angles::WIDTH {
                rho[i] = (x[i] * x[i] + y[i] * y[i]).sqrt();
            }
            let phi = locator.angles.of::<FUSED>(&x, &y);
            let theta = locator.angles.of::<FUSED>(&z, &rho);
            let mut first = [[0_u32; angles::WIDTH]; 2];
            let mut t = [[0.0; angles::WIDTH]; 2];
            for (axis, (turns, n)) in
                [(theta, locator.n_theta), (phi, locator.n_phi)].into_iter().enumerate()
            {
                let n = n as f64;
                for i in 0..angles::WIDTH {
                    let (base, rest) = (turns.eighths[i] * 0.125 * n, turns.rest[i] * n);
                    // Rounding up by rounding down, which has an instruction on every machine: the
                    // sum is positive.
                    let below = (base + rest - half + margin) as u32;
                    let short = f64::from(below) - margin < base + rest - half;
                    let place = if short { below + 1 } else { below };
                    let start = f64::from(place) - margin;
                    first[axis][i] = place;
                    // The product is not rounded before the difference, which is small.
                    let offset = turns.rest[i].times_plus::<FUSED>(n, base - start - half);
                    t[axis][i] = 2.0 * offset + 1.0;
                }
            }
            let weights = weights.map(|w| &w[chunk * angles::WIDTH..]);
            for (i, cell) in cells.iter_mut().enumerate() {
                *cell = Cell {
                    row: first[0][i],
                    column: first[1][i],
                    t: [T::of(t[0][i]), T::of(t[1][i])],
                    weight: T::of(weights.map_or(scale, |w| w[i] * scale)),
                    index,
                };
                index += 1;
            }
        }
    }
}
