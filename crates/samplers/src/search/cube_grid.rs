use glam::{DVec3, IVec3};

/// End of a cell's list.
const NONE: u32 = u32::MAX;

/// Unit vectors in the cells of a cubic grid over [-1, 1]^3, for nearest-distance queries. It grows
/// by insertion; its owner rebuilds it when cells become crowded.
#[derive(Debug)]
pub(crate) struct CubeGrid {
    cells_per_side: i32,
    /// The last point inserted into each cell, and for each point the one inserted before it.
    last: Vec<u32>,
    earlier: Vec<u32>,
}

impl CubeGrid {
    /// At most 2 million cells, 8 MiB.
    const MAX_CELLS_PER_SIDE: f64 = 128.0;

    /// Returns an empty grid whose cells are as wide as the spacing of `n_points` evenly spread
    /// points.
    #[expect(clippy::cast_possible_truncation, reason = "from 1 to MAX_CELLS_PER_SIDE")]
    pub(crate) fn for_points(n_points: usize) -> Self {
        // Optimally packed points are 3.8/sqrt(N) apart, best candidates about 3/sqrt(N).
        let cells = 2.0 * (n_points as f64).sqrt() / 3.0;
        let cells_per_side = cells.clamp(1.0, Self::MAX_CELLS_PER_SIDE) as i32;
        let n_cells = cells_per_side.unsigned_abs().pow(3) as usize;
        Self { cells_per_side, last: vec![NONE; n_cells], earlier: Vec::new() }
    }

    /// Inserts `p` with the next index from 0.
    #[expect(clippy::cast_possible_truncation, reason = "patterns have at most u32::MAX points")]
    pub(crate) fn insert(&mut self, p: DVec3) {
        let cell = self.index(self.cell(p));
        self.earlier.push(self.last[cell]);
        self.last[cell] = (self.earlier.len() - 1) as u32;
    }

    /// Returns the squared distance of `p` from the nearest of `points`, which are those inserted,
    /// or `None` once one is found whose squared distance does not exceed `bound`.
    pub(crate) fn clearance(&self, points: &[DVec3], p: DVec3, bound: f64) -> Option<f64> {
        let centre = self.cell(p);
        let width = 2.0 / f64::from(self.cells_per_side);
        let mut nearest = f64::INFINITY;
        for ring in 0..=self.cells_per_side {
            self.visit_ring(centre, ring, |number| {
                nearest = nearest.min(points[number as usize].distance_squared(p));
                nearest > bound
            })?;
            // Points in cells beyond are farther than the full cells between.
            let reach = f64::from(ring) * width;
            if nearest <= reach * reach {
                break;
            }
        }
        Some(nearest)
    }

    /// Calls `visit` for the points in cells at Chebyshev distance `ring` from `centre` until it
    /// returns false; returns `None` in that case.
    fn visit_ring(
        &self,
        centre: IVec3,
        ring: i32,
        mut visit: impl FnMut(u32) -> bool,
    ) -> Option<()> {
        let top = self.cells_per_side - 1;
        let within = |c: i32| (c - ring).max(0)..=(c + ring).min(top);
        for x in within(centre.x) {
            for y in within(centre.y) {
                let side = (x - centre.x).abs() == ring || (y - centre.y).abs() == ring;
                // Inside the ring only the bottom and top layers remain.
                let step = if side || ring == 0 { 1 } else { 2 * ring };
                let mut z = centre.z - ring;
                while z <= centre.z + ring {
                    if (0..=top).contains(&z) {
                        let mut number = self.last[self.index(IVec3::new(x, y, z))];
                        while number != NONE {
                            if !visit(number) {
                                return None;
                            }
                            number = self.earlier[number as usize];
                        }
                    }
                    z += step;
                }
            }
        }
        Some(())
    }

    fn cell(&self, p: DVec3) -> IVec3 {
        let scaled = (p + 1.0) * (0.5 * f64::from(self.cells_per_side));
        scaled.as_ivec3().clamp(IVec3::ZERO, IVec3::splat(self.cells_per_side - 1))
    }

    fn index(&self, cell: IVec3) -> usize {
        let side = self.cells_per_side;
        ((cell.x * side + cell.y) * side + cell.z).unsigned_abs() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::CubeGrid;
    use crate::{Domain, Pattern, Purpose, Streams};

    #[test]
    fn clearances_match_an_exhaustive_search() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        let mut sample = |n| Pattern::WhiteNoise.build(n, Domain::Sphere)?.sample(&mut rng);
        for n in [1, 2, 3, 10, 300] {
            let points = sample(n).unwrap().points;
            // Grids sized for far fewer or far more points are slow but correct.
            for made_for in [1, n, 40 * n] {
                let mut grid = CubeGrid::for_points(made_for);
                points.iter().for_each(|&p| grid.insert(p));
                for p in sample(50).unwrap().points {
                    let nearest = points.iter().map(|q| q.distance_squared(p));
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    let found = |bound| grid.clearance(&points, p, bound);
                    assert_eq!(found(-1.0), Some(nearest), "{n} points, {p}");
                    assert_eq!(found(0.99 * nearest), Some(nearest), "{n} points, {p}");
                    assert_eq!(found(nearest), None, "{n} points, {p}");
                }
            }
        }
    }
}
