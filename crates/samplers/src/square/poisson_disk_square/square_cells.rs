use glam::DVec2;

use crate::disks::Subdivision;
use crate::search::SquareGrid;

/// The finest resolution, in cells per side.
const MAX_SIDE: u32 = 1 << 30;

/// The largest coordinate of a point.
const BELOW_1: f64 = 1.0 - f64::EPSILON / 2.0;

/// Distances on the square are below this, whether its sides are joined or not.
const BEYOND_ALL: f64 = 1.5;

/// The unit square divided into squares, and the centres of disks on it; opposite sides may be
/// joined.
#[derive(Debug)]
pub(super) struct SquareCells {
    radius: f64,
    grid: SquareGrid,
}

/// Column and row of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    ix: u32,
    iy: u32,
}

/// The coordinates of the corners of the four children of a cell.
#[derive(Debug)]
pub(super) struct Quarters {
    x: [f64; 3],
    y: [f64; 3],
}

impl SquareCells {
    /// Returns the square without disks; `radius` is that of the disks to come, any positive
    /// number, and about `n_points` of them are expected.
    pub(super) fn new(is_wrapped: bool, radius: f64, n_points: f64) -> Self {
        let radius = radius.min(BEYOND_ALL);
        Self { radius, grid: SquareGrid::new(is_wrapped, radius, n_points) }
    }

    /// Adds the disk around a point of the square.
    pub(super) fn insert_at(&mut self, point: DVec2) {
        self.grid.insert(self.grid.index_of(point), point);
    }
}

impl Subdivision for SquareCells {
    type Point = DVec2;
    type Output = [f64; 2];
    type Place = Place;
    type Resolution = u32;
    type Quarters = Quarters;

    fn grid_cells(&self) -> impl Iterator<Item = (Place, u32)> {
        let side = self.grid.side();
        (0..side)
            .flat_map(move |iy| (0..side).map(move |ix| Place { ix, iy }))
            .map(|place| (place, self.grid.index(place.ix, place.iy)))
    }

    fn resolution(&self, level: u32) -> Option<u32> {
        self.grid
            .side()
            .checked_shl(level)
            .filter(|&side| side >> level == self.grid.side() && side <= MAX_SIDE)
    }

    fn cell_area(&self, level: u32) -> f64 {
        (f64::from(self.grid.side()) * f64::from(level).exp2()).powi(-2)
    }

    #[inline]
    fn child(&self, place: Place, child: u32) -> Place {
        Place { ix: 2 * place.ix + (child & 1), iy: 2 * place.iy + (child >> 1) }
    }

    #[inline]
    fn point_in(&self, place: Place, side: u32, u: f64, v: f64) -> Option<DVec2> {
        let point = DVec2::new(f64::from(place.ix) + u, f64::from(place.iy) + v);
        Some((point / f64::from(side)).min(DVec2::splat(BELOW_1)))
    }

    #[inline]
    fn quarters(&self, place: Place, side: u32, level: u32) -> Option<(Quarters, u32)> {
        let corners = |i: u32| [0.0, 0.5, 1.0].map(|half| (f64::from(i) + half) / f64::from(side));
        let index = self.grid.index(place.ix >> level, place.iy >> level);
        Some((Quarters { x: corners(place.ix), y: corners(place.iy) }, index))
    }

    #[inline]
    fn select(&self, quarters: &Quarters, points: &[DVec2], near: &mut Vec<DVec2>) {
        let low = DVec2::new(quarters.x[0], quarters.y[0]);
        let high = DVec2::new(quarters.x[2], quarters.y[2]);
        let reach = self.radius + ROUNDING;
        let touches = |p: &&DVec2| p.distance_squared(p.clamp(low, high)) < reach * reach;
        near.clear();
        near.extend(points.iter().filter(touches));
    }

    /// A disk that holds the four corners of a square holds the square.
    #[inline]
    fn covered(&self, quarters: &Quarters, points: &[DVec2]) -> u32 {
        let inner = self.radius - ROUNDING;
        if inner <= 0.0 {
            return 0;
        }
        let mut covered = 0;
        for p in points {
            let squares = |corners: [f64; 3], at: f64| corners.map(|c| (c - at) * (c - at));
            let (x, y) = (squares(quarters.x, p.x), squares(quarters.y, p.y));
            let farther = |of: [f64; 3]| [of[0].max(of[1]), of[1].max(of[2])];
            let (x, y) = (farther(x), farther(y));
            for child in 0..4_u32 {
                let farthest = x[child as usize & 1] + y[child as usize >> 1];
                covered |= u32::from(farthest <= inner * inner) << child;
            }
        }
        covered
    }

    fn gather(&self, grid_place: u32, near: &mut Vec<DVec2>) {
        near.clear();
        near.extend(self.grid.near(grid_place));
    }

    #[inline]
    fn overlap(&self, a: DVec2, b: DVec2) -> bool {
        a.distance_squared(b) < self.radius * self.radius
    }

    #[inline]
    fn is_covered(&self, grid_place: u32, point: DVec2) -> bool {
        self.grid.near(grid_place).any(|p| self.overlap(p, point))
    }

    #[inline]
    fn insert(&mut self, grid_place: u32, point: DVec2) {
        self.grid.insert(grid_place, point);
    }

    #[inline]
    fn output(&self, point: DVec2) -> [f64; 2] {
        point.into()
    }
}

/// More than the rounding of a distance of coordinates below 2 in magnitude.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
