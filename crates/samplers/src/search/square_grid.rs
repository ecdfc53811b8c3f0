use glam::DVec2;

use super::chains::Chains;

/// Points of the unit square in the cells of a regular grid, for queries within a fixed distance.
///
/// Opposite sides of the square are joined (a torus) or not. A query in a cell sees the points of
/// the cell and of those around it, across a joined side at the place of their periodic image, so
/// that plain differences of coordinates are those of the nearest image.
#[derive(Debug)]
pub(crate) struct SquareGrid {
    side: u32,
    is_wrapped: bool,
    chains: Chains<DVec2>,
}

impl SquareGrid {
    /// Maximum number of cells per side: 2^28 cells.
    const MAX_SIDE: f64 = 16384.0;

    /// Returns an empty grid for queries within `distance`, any positive number, among about
    /// `n_points` points; more points only take longer.
    pub(crate) fn new(is_wrapped: bool, distance: f64, n_points: f64) -> Self {
        // For tiny distances one cell per point suffices. The margin makes cells wider than the
        // distance in spite of rounding.
        let side = ((1.0 - 1e-12) / distance).min(n_points.sqrt()).clamp(1.0, Self::MAX_SIDE);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 1 to MAX_SIDE"
        )]
        let side = side as u32;
        let n_cells = side as usize * side as usize;
        Self { side, is_wrapped, chains: Chains::new(n_cells) }
    }

    /// Returns the number of cells per side.
    pub(crate) fn side(&self) -> u32 {
        self.side
    }

    /// Returns the index of the cell in column `ix` and row `iy`.
    #[inline]
    pub(crate) fn index(&self, ix: u32, iy: u32) -> u32 {
        iy * self.side + ix
    }

    /// Returns the index of the cell that contains a point of the square.
    pub(crate) fn index_of(&self, point: DVec2) -> u32 {
        let scaled = point * f64::from(self.side);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "coordinates in [0, 1), limited to the last cell"
        )]
        let cell = |x: f64| (x as u32).min(self.side - 1);
        self.index(cell(scaled.x), cell(scaled.y))
    }

    /// Inserts a point into the cell of that index, which contains it.
    #[inline]
    pub(crate) fn insert(&mut self, index: u32, point: DVec2) {
        self.chains.insert(index, point);
    }

    /// Returns all points that can lie within the distance of the cell of that index, at the
    /// periodic images nearest to the cell.
    #[inline]
    pub(crate) fn near(&self, index: u32) -> impl Iterator<Item = DVec2> {
        self.around(index)
            .flat_map(|(cell, shift)| self.chains.points(cell).map(move |p| p + shift))
    }

    /// Returns the numbers of the points of [`Self::near`], in order of insertion from 0. In a grid
    /// of fewer than three cells per side a number can occur for several images.
    pub(crate) fn near_numbers(&self, index: u32) -> impl Iterator<Item = u32> {
        self.around(index).flat_map(|(cell, _)| self.chains.numbers(cell))
    }

    /// Returns the cell of that index and those around it, each with the shift to its periodic
    /// image.
    #[inline]
    fn around(&self, index: u32) -> impl Iterator<Item = (u32, DVec2)> {
        let (ix, iy) = (index % self.side, index / self.side);
        let rows = [0, 1, 2].map(|step| self.beside(iy, step));
        let columns = [0, 1, 2].map(|step| self.beside(ix, step));
        rows.into_iter().flatten().flat_map(move |(row, up)| {
            let columns = columns.into_iter().flatten();
            columns.map(move |(column, right)| (self.index(column, row), DVec2::new(right, up)))
        })
    }

    /// Returns the column or row `step - 1` beyond one, and the shift of its periodic image.
    #[inline]
    fn beside(&self, at: u32, step: u32) -> Option<(u32, f64)> {
        let last = self.side - 1;
        match (at + step).checked_sub(1) {
            Some(at) if at <= last => Some((at, 0.0)),
            None if self.is_wrapped => Some((last, -1.0)),
            Some(_) if self.is_wrapped => Some((0, 1.0)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec2, SquareGrid};
    use crate::{Purpose, Streams};
    use rand::RngExt;

    /// The reference is a search through all points and images. Coordinates include the ends of
    /// [0, 1).
    #[test]
    fn queries_match_an_exhaustive_search() {
        let mut rng = Streams::new(6, Purpose::Pattern, 0).realization(0);
        let ends = [0.0, 1.0 - f64::EPSILON / 2.0];
        let mut points: Vec<DVec2> =
            ends.iter().flat_map(|&u| ends.map(|v| DVec2::new(u, v))).collect();
        points.extend((0..300).map(|_| DVec2::from_array(rng.random())));
        for is_wrapped in [false, true] {
            for distance in [0.01, 0.05, 0.2, 0.3, 0.34, 0.5, 0.6, 1.0] {
                for n_points in [1.0, 20.0, 300.0] {
                    let mut grid = SquareGrid::new(is_wrapped, distance, n_points);
                    for &p in &points {
                        grid.insert(grid.index_of(p), p);
                    }
                    for &p in points.iter().step_by(7) {
                        let reach = i32::from(is_wrapped);
                        let mut expected: Vec<DVec2> = (-reach..=reach)
                            .flat_map(|y| (-reach..=reach).map(move |x| (x, y)))
                            .map(|(x, y)| DVec2::new(f64::from(x), f64::from(y)))
                            .flat_map(|shift| points.iter().map(move |&q| q + shift))
                            .filter(|q| q.distance(p) < distance)
                            .collect();
                        let mut found: Vec<DVec2> = grid
                            .near(grid.index_of(p))
                            .filter(|q| q.distance(p) < distance)
                            .collect();
                        for all in [&mut expected, &mut found] {
                            all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
                        }
                        assert_eq!(found, expected, "wrapped: {is_wrapped}, {distance}, {p}");
                    }
                }
            }
        }
    }
}
