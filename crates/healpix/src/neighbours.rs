use crate::Cell;
use crate::cell_map::face_in_row;

/// Steps `(north-east, north-west)` towards SW, W, NW, N, NE, E, SE, S.
const STEPS: [(i64, i64); 8] =
    [(-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1)];

/// Adjacency.
impl Cell {
    /// Returns the cells that share an edge or a corner with this one, towards SW, W, NW, N, NE, E,
    /// SE, S.
    ///
    /// An entry is `None` where three faces instead of four meet at a corner, which happens at the
    /// eight points with `|z| = 2/3` and `phi` a multiple of pi/2. The order is that of healpy's
    /// `get_all_neighbours`. In the caps "north" is a direction in the face, not on the sphere: the
    /// northern neighbour of a cell at the pole lies on the other side of the pole. At nside 1 and
    /// 2 two cells may touch at several places and are then listed once per direction.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let cell = Cell::new(Nside::new(4)?, 0, 3, 3)?;
    /// let [_, _, north_west, north, ..] = cell.neighbours();
    /// assert_eq!(north_west.map(Cell::face), Some(3));
    /// assert_eq!(north.map(Cell::face), Some(2));
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    pub fn neighbours(self) -> [Option<Self>; 8] {
        STEPS.map(|(dx, dy)| self.step(dx, dy))
    }

    fn step(self, dx: i64, dy: i64) -> Option<Self> {
        let n = i64::from(self.nside().value());
        let x = i64::from(self.ix()) + dx;
        let y = i64::from(self.iy()) + dy;
        let east = u32::from(self.face() % 4) + 1;
        let (here, west, opposite) = (east - 1, east + 2, east + 1);
        let last = n - 1;

        // The face that the step leads to, and the position in its coordinates. Across the edges at
        // the poles, rows 0 and 2 meet their own row, rotated by pi/2; elsewhere the axes continue.
        let (row, column, x, y) = match (self.face() / 4, side(x, n), side(y, n)) {
            (row, Side::Inside, Side::Inside) => (row, here, x, y),

            (0, Side::Above, Side::Inside) => (0, east, y, last),
            (0, Side::Inside, Side::Above) => (0, west, last, x),
            (0, Side::Above, Side::Above) => (0, opposite, last, last),
            (0, Side::Inside, Side::Below) => (1, east, x, last),
            (0, Side::Below, Side::Inside) => (1, here, last, y),
            (0, Side::Below, Side::Below) => (2, here, last, last),

            (1, Side::Above, Side::Inside) => (0, here, 0, y),
            (1, Side::Inside, Side::Above) => (0, west, x, 0),
            (1, Side::Inside, Side::Below) => (2, here, x, last),
            (1, Side::Below, Side::Inside) => (2, west, last, y),
            (1, Side::Above, Side::Below) => (1, east, 0, last),
            (1, Side::Below, Side::Above) => (1, west, last, 0),

            (2, Side::Above, Side::Inside) => (1, east, 0, y),
            (2, Side::Inside, Side::Above) => (1, here, x, 0),
            (2, Side::Inside, Side::Below) => (2, east, 0, x),
            (2, Side::Below, Side::Inside) => (2, west, y, 0),
            (2, Side::Below, Side::Below) => (2, opposite, 0, 0),
            (2, Side::Above, Side::Above) => (0, here, 0, 0),

            _ => return None,
        };
        let (ix, iy) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        Some(Self::in_range(self.nside(), face_in_row(row, column), ix, iy))
    }
}

/// Position of a coordinate relative to the face.
#[derive(Debug, Clone, Copy)]
enum Side {
    Below,
    Inside,
    Above,
}

fn side(coordinate: i64, n: i64) -> Side {
    if coordinate < 0 {
        Side::Below
    } else if coordinate < n {
        Side::Inside
    } else {
        Side::Above
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Nside, PixelOrder, Ring};

    /// Returns whether the cells have a corner in common.
    fn touch(a: Cell, b: Cell) -> bool {
        // Corners of a nside 8 grid are at least 0.1 apart.
        a.corners().iter().any(|p| b.corners().iter().any(|q| p.distance(*q) < 1e-3))
    }

    #[test]
    fn neighbours_are_the_cells_that_touch() {
        for n in 1..=8 {
            let order = Ring::new(Nside::new(n).unwrap());
            let cells: Vec<Cell> = (0..order.n_pixels()).map(|p| order.cell(p)).collect();
            for &cell in &cells {
                let mut found: Vec<u64> =
                    cell.neighbours().iter().flatten().map(|&c| order.pixel_of_cell(c)).collect();
                found.sort_unstable();
                found.dedup();
                let expected: Vec<u64> = cells
                    .iter()
                    .filter(|&&other| other != cell && touch(cell, other))
                    .map(|&other| order.pixel_of_cell(other))
                    .collect();
                assert_eq!(found, expected, "{cell:?}");
            }
        }
    }
}
