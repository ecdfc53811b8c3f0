use glam::DVec3;
use sphvar_healpix::{Cell, Nside};

use super::quarters::Quarters;
use crate::Domain;
use crate::disks::Subdivision;
use crate::search::Grid;

const FOUR_PI: f64 = 4.0 * std::f64::consts::PI;

/// The sphere or hemisphere divided into HEALPix cells, and the centres of disks on it.
#[derive(Debug)]
pub(super) struct SphereCells {
    domain: Domain,
    chord: f64,
    grid: Grid,
}

impl SphereCells {
    /// Returns the domain without disks; `chord` is the radius of those to come, any positive
    /// number, and about `n_points` of them are expected.
    pub(super) fn new(domain: Domain, chord: f64, n_points: f64) -> Self {
        Self { domain, chord, grid: Grid::new(domain, chord, n_points) }
    }

    /// Adds the disk around a point of the domain.
    pub(super) fn insert_at(&mut self, point: DVec3) {
        self.grid.insert(self.grid.place(Cell::containing(self.grid.nside(), point)), point);
    }

    fn nside(&self, level: u32) -> u32 {
        self.grid.nside().value() << level
    }
}

impl Subdivision for SphereCells {
    type Point = DVec3;
    type Output = DVec3;
    type Place = Place;
    type Resolution = Nside;
    type Quarters = Quarters;

    fn grid_cells(&self) -> impl Iterator<Item = (Place, u32)> {
        let nside = self.grid.nside();
        // The northern faces and the first two of the equator hold one cell of every antipodal
        // pair, which has the area of a hemisphere and represents all antipodal pairs.
        let faces = match self.domain {
            Domain::Sphere => 12,
            Domain::Hemisphere => 6,
        };
        let n = nside.value();
        (0..faces)
            .flat_map(move |face| (0..n).map(move |iy| (face, iy)))
            .flat_map(move |(face, iy)| (0..n).map(move |ix| (face, ix, iy)))
            .filter_map(move |(face, ix, iy)| Cell::new(nside, face, ix, iy).ok())
            .map(|cell| (Place::of(cell), self.grid.place(cell)))
    }

    fn resolution(&self, level: u32) -> Option<Nside> {
        Nside::new(self.nside(level)).ok()
    }

    fn cell_area(&self, level: u32) -> f64 {
        FOUR_PI / (12.0 * f64::from(self.nside(level)).powi(2))
    }

    #[inline]
    fn child(&self, place: Place, child: u32) -> Place {
        place.child(child)
    }

    #[inline]
    fn point_in(&self, place: Place, nside: Nside, u: f64, v: f64) -> Option<DVec3> {
        Some(place.cell(nside)?.uniform_point(u, v))
    }

    #[inline]
    fn quarters(&self, place: Place, nside: Nside, level: u32) -> Option<(Quarters, u32)> {
        let cell = place.cell(nside)?;
        Some((Quarters::new(cell, self.chord), self.grid.place_above(cell, level)))
    }

    #[inline]
    fn select(&self, quarters: &Quarters, points: &[DVec3], near: &mut Vec<DVec3>) {
        near.resize(points.len(), DVec3::ZERO);
        let len = quarters.select(points, self.chord, near);
        near.truncate(len);
    }

    #[inline]
    fn covered(&self, quarters: &Quarters, points: &[DVec3]) -> u32 {
        quarters.covered(points, self.chord)
    }

    fn gather(&self, grid_place: u32, near: &mut Vec<DVec3>) {
        self.grid.gather(grid_place, near);
    }

    #[inline]
    fn overlap(&self, a: DVec3, b: DVec3) -> bool {
        a.distance_squared(b) < self.chord * self.chord
    }

    #[inline]
    fn is_covered(&self, grid_place: u32, point: DVec3) -> bool {
        self.grid.has_near(grid_place, point, self.chord * self.chord)
    }

    #[inline]
    fn insert(&mut self, grid_place: u32, point: DVec3) {
        self.grid.insert(grid_place, point);
    }

    #[inline]
    fn output(&self, point: DVec3) -> DVec3 {
        self.domain.representative(point)
    }
}

/// Face and coordinates of a cell in 64 bits: 4 for the face, 29 for each coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place(u64);

impl Place {
    const BITS: u32 = 29;
    const MASK: u64 = (1 << Self::BITS) - 1;

    fn of(cell: Cell) -> Self {
        let (ix, iy) = (u64::from(cell.ix()), u64::from(cell.iy()));
        Self(u64::from(cell.face()) << (2 * Self::BITS) | ix << Self::BITS | iy)
    }

    #[inline]
    fn cell(self, nside: Nside) -> Option<Cell> {
        let field = |shift: u32| u32::try_from(self.0 >> shift & Self::MASK).ok();
        let face = u8::try_from(field(2 * Self::BITS)?).ok()?;
        Cell::new(nside, face, field(Self::BITS)?, field(0)?).ok()
    }

    /// Child 0 to 3 at twice the resolution, at most 2^29, so that no field overflows.
    #[inline]
    fn child(self, child: u32) -> Self {
        let child = u64::from(child);
        let below_face = (1 << (2 * Self::BITS)) - 1;
        let doubled = (self.0 & below_face) << 1;
        Self(self.0 & !below_face | doubled | (child & 1) << Self::BITS | child >> 1)
    }
}
