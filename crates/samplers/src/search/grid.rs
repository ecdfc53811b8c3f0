use glam::DVec3;
use sphvar_healpix::{Cell, Nside};

use super::chains::Chains;
use crate::Domain;

/// A lower bound, times nside, on the distance between cells that do not touch: every point within
/// `REACH / nside` (chord) of a cell lies in that cell or in one of its neighbours.
///
/// The narrowest strip between opposite sides of a cell is that of the long cells beside a polar
/// face's edge, close to the pole: area over length of the long side,
/// `(pi/3) / sqrt(2/3 (1 + pi^2/4))` = 0.6888. Elsewhere and at small nside the distance is larger,
/// as the test below measures. The value is rounded down.
const REACH: f64 = 0.68;

/// The grid of the largest disks.
const COARSEST: Nside = match Nside::new(1) {
    Ok(nside) => nside,
    Err(_) => unreachable!(),
};

/// The accepted points, indexed by location: HEALPix cells about as wide as the disks, each the
/// head of a chain of its points.
///
/// Memory: 32 bytes per point (64 on the hemisphere, where each point is inserted with its
/// antipode, so that queries need not handle the equator) and 4 bytes per cell, of which there are
/// about 0.64 per point.
#[derive(Debug)]
pub(crate) struct Grid {
    nside: Nside,
    /// Whether the disks are so large that all cells form one neighbourhood.
    is_whole: bool,
    domain: Domain,
    chains: Chains<DVec3>,
}

impl Grid {
    /// Returns an empty grid for disks of radius `chord`, of which about `n_points` are expected;
    /// more disks only take longer.
    pub(crate) fn new(domain: Domain, chord: f64, n_points: f64) -> Self {
        // For tiny disks one cell per point suffices.
        let nside = (REACH / chord).min((n_points / 12.0).sqrt()).max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least 1 and below 2^16, since n_points is below 2^32"
        )]
        let nside = Nside::new(nside as u32).unwrap_or(COARSEST);
        let n = nside.value() as usize;
        Self { nside, is_whole: chord > REACH, domain, chains: Chains::new(12 * n * n) }
    }

    pub(crate) fn nside(&self) -> Nside {
        self.nside
    }

    /// Returns the index of `cell` in the grid, which has the cell's resolution.
    #[inline]
    pub(crate) fn place(&self, cell: Cell) -> u32 {
        let n = self.nside.value();
        (u32::from(cell.face()) * n + cell.iy()) * n + cell.ix()
    }

    /// Returns the index of the grid cell that contains `cell`, which is `level` subdivisions
    /// finer.
    #[inline]
    pub(crate) fn place_above(&self, cell: Cell, level: u32) -> u32 {
        let n = self.nside.value();
        (u32::from(cell.face()) * n + (cell.iy() >> level)) * n + (cell.ix() >> level)
    }

    #[inline]
    fn cell(&self, place: u32) -> Option<Cell> {
        let n = self.nside.value();
        let face = u8::try_from(place / (n * n)).ok()?;
        Cell::new(self.nside, face, place % n, place / n % n).ok()
    }

    /// Inserts `dir`, which lies in the cell at `place`.
    #[inline]
    pub(crate) fn insert(&mut self, place: u32, dir: DVec3) {
        self.chains.insert(place, dir);
        if self.domain == Domain::Hemisphere
            && let Some(cell) = self.cell(place)
        {
            self.chains.insert(self.place(cell.antipode()), -dir);
        }
    }

    /// Returns whether the grid contains a point within the square root of `chord_squared` of
    /// `dir`, which lies in the cell at `place`.
    #[inline]
    pub(crate) fn has_near(&self, place: u32, dir: DVec3, chord_squared: f64) -> bool {
        self.neighbourhood(place)
            .any(|p| self.chains.points(p).any(|q| q.distance_squared(dir) < chord_squared))
    }

    /// Replaces the content of `near` by all points that can lie within the disks' radius of the
    /// cell at `place`.
    pub(crate) fn gather(&self, place: u32, near: &mut Vec<DVec3>) {
        near.clear();
        near.extend(self.near(place));
    }

    /// Returns all points that can lie within the disks' radius of the cell at `place`.
    #[inline]
    pub(crate) fn near(&self, place: u32) -> impl Iterator<Item = DVec3> {
        self.neighbourhood(place).flat_map(|p| self.chains.points(p))
    }

    /// Returns the numbers of all points that can lie within the disks' radius of the cell at
    /// `place`: the k-th inserted point, from 0, has the number k, on the hemisphere 2k and its
    /// antipode 2k + 1.
    pub(crate) fn near_numbers(&self, place: u32) -> impl Iterator<Item = u32> {
        self.neighbourhood(place).flat_map(|p| self.chains.numbers(p))
    }

    /// Returns the indices of the cell at `place` and of the cells around it.
    #[inline]
    fn neighbourhood(&self, place: u32) -> impl Iterator<Item = u32> {
        let n = self.nside.value();
        let (ix, iy) = (place % n, place / n % n);
        let inner = |i: u32| i > 0 && i + 1 < n;
        let mut places = [place; 12];
        let mut len = 9;
        if self.is_whole {
            places = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
            len = 12;
        } else if inner(ix) && inner(iy) {
            let (below, above) = (place - n, place + n);
            places[1..9].copy_from_slice(&[
                place - 1,
                place + 1,
                below,
                above,
                below - 1,
                below + 1,
                above - 1,
                above + 1,
            ]);
        } else if let Some(cell) = self.cell(place) {
            len = 1;
            for neighbour in cell.neighbours().into_iter().flatten() {
                places[len] = self.place(neighbour);
                len += 1;
            }
        }
        places.into_iter().take(len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(n: u32) -> Vec<Cell> {
        let nside = Nside::new(n).unwrap();
        (0..12)
            .flat_map(|face| (0..n * n).map(move |i| Cell::new(nside, face, i % n, i / n).unwrap()))
            .collect()
    }

    fn boundary(cell: Cell) -> Vec<DVec3> {
        const STEPS: u32 = 12;
        (0..STEPS)
            .map(|i| f64::from(i) / f64::from(STEPS))
            .flat_map(|t| [(t, 0.0), (1.0, t), (1.0 - t, 1.0), (0.0, 1.0 - t)])
            .map(|(u, v)| cell.uniform_point(u, v))
            .collect()
    }

    /// The minimum distance between cells that do not touch, times nside, decreases with nside:
    /// 0.816 at 1, 0.713 at 8, 0.695 at 64, towards 0.689.
    #[test]
    fn cells_that_do_not_touch_are_farther_apart_than_the_reach() {
        for n in [1, 2, 3, 4, 5, 8, 16] {
            let cells = cells(n);
            // The other cells are images of these under symmetries of the grid.
            for &a in cells.iter().filter(|c| c.face() % 4 == 0 && c.face() < 8 && c.ix() <= c.iy())
            {
                let touching = a.neighbours();
                let edge = boundary(a);
                for &b in cells.iter().filter(|&&b| b != a && !touching.contains(&Some(b))) {
                    if n > 3 && b.centre().distance(a.centre()) > 3.5 / f64::from(n) {
                        continue;
                    }
                    for p in boundary(b) {
                        let min_distance =
                            edge.iter().map(|q| q.distance(p)).fold(f64::MAX, f64::min);
                        assert!(
                            min_distance * f64::from(n) > REACH,
                            "{a:?} and {b:?}: {min_distance}"
                        );
                    }
                }
            }
        }
    }

    /// The reference is a search through all points. The points are a spiral with points at both
    /// poles, with disks of every size.
    #[test]
    fn queries_match_an_exhaustive_search() {
        const POINTS: u32 = 400;
        let spiral: Vec<DVec3> = (0..=POINTS)
            .map(|i| {
                let z = 1.0 - 2.0 * f64::from(i) / f64::from(POINTS);
                let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
                let rho = (1.0 - z * z).sqrt();
                DVec3::new(rho * cos, rho * sin, z)
            })
            .collect();
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for chord in [0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.67, 0.69, 1.0, 1.5, 2.5] {
                let mut grid = Grid::new(domain, chord, 400.0);
                let place = |grid: &Grid, dir| grid.place(Cell::containing(grid.nside(), dir));
                let (entered, queried) = spiral.split_at(POINTS as usize / 2);
                let dirs = entered.iter().map(|&dir| DVec3::new(dir.z, dir.x, dir.y));
                for dir in dirs.clone() {
                    grid.insert(place(&grid, dir), dir);
                }
                let squared = chord * chord;
                for &dir in queried {
                    let expected = dirs.clone().any(|q| {
                        let opposite = domain == Domain::Hemisphere;
                        q.distance_squared(dir) < squared
                            || opposite && q.distance_squared(-dir) < squared
                    });
                    let found = grid.has_near(place(&grid, dir), dir, squared);
                    assert_eq!(found, expected, "{domain}, chord {chord}, {dir}");
                }
            }
        }
    }
}
