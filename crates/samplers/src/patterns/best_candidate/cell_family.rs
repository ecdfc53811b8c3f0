use glam::DVec3;

use super::cell_place::CellPlace;

/// The number of the family of children that do not exist: family 0 has the roots.
pub(super) const NONE: u32 = 0;

/// The four children of a cell, or four roots.
///
/// What a new point needs of them is contiguous: 224 bytes are read at once, instead of four times
/// as many cache lines one after the other.
#[derive(Clone, Debug)]
pub(super) struct CellFamily {
    x: [f64; 4],
    y: [f64; 4],
    z: [f64; 4],
    /// No point of a cell is farther from its centre.
    radius: [f64; 4],
    /// The distance of the centres from the nearest site.
    distance: [f64; 4],
    /// No point of a cell is farther from the nearest site.
    bound: [f64; 4],
    /// The families of children, or `NONE`.
    children: [u32; 4],
    /// The first of the four cells.
    first: CellPlace,
}

/// One cell of a family.
#[derive(Clone, Copy, Debug)]
pub(super) struct FamilyCell {
    pub(super) place: CellPlace,
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    pub(super) distance: f64,
    pub(super) bound: f64,
    pub(super) children: u32,
}

impl FamilyCell {
    /// Returns the distance from the centre within which the nearest sites of all points of the
    /// cell lie: they are at most `distance + radius` away from points that are at most `radius`
    /// away from the centre.
    pub(super) fn reach(&self) -> f64 {
        (self.distance + 2.0 * self.radius) * (1.0 + 4.0 * f64::EPSILON)
    }
}

impl CellFamily {
    /// The places of the cells relative to the first one: of roots the faces, of others the columns
    /// and rows.
    const OFFSETS: [(u8, u32, u32); 4] = [(0, 0, 0), (1, 1, 0), (2, 0, 1), (3, 1, 1)];

    /// Returns four roots from a face on, those of them below `n_roots`; no site is near the
    /// others.
    pub(super) fn of_roots(face: u8, n_roots: u8, sites: &[DVec3]) -> Self {
        let mut family = Self {
            x: [0.0; 4],
            y: [0.0; 4],
            z: [0.0; 4],
            radius: [0.0; 4],
            distance: [f64::NEG_INFINITY; 4],
            bound: [0.0; 4],
            children: [NONE; 4],
            first: CellPlace::root(face),
        };
        for (index, face) in (face..n_roots).take(4).enumerate() {
            let place = CellPlace::root(face);
            let centre = place.point(0.5, 0.5);
            let (mut distance, mut far) = (f64::INFINITY, f64::INFINITY);
            for &site in sites {
                distance = distance.min(site.distance_squared(centre));
                far = far.min(farthest(place.corners(), site));
            }
            let radius = farthest(place.corners(), centre);
            family.set(index, centre, [distance, far, radius], f64::INFINITY);
        }
        family
    }

    /// Returns the children of a cell with its corners, centre and bound. `sites` contain the
    /// nearest ones of all points of the cell.
    pub(super) fn of_children(
        parent: CellPlace,
        grid: &Corners,
        bound: f64,
        sites: &[DVec3],
    ) -> Self {
        let centre = [0, 1, 2, 3].map(|child| parent.child(child).point(0.5, 0.5));
        let mut distance = [f64::INFINITY; 4];
        let mut far = [f64::INFINITY; 4];
        for &site in sites {
            let corners = grid.0.map(|corner| corner.distance_squared(site));
            for child in 0..4 {
                distance[child] = distance[child].min(site.distance_squared(centre[child]));
                let [a, b, c, d] = Corners::OF_CHILDREN[child].map(|at| corners[at]);
                far[child] = far[child].min(a.max(b).max(c.max(d)));
            }
        }
        let mut family = Self {
            x: [0.0; 4],
            y: [0.0; 4],
            z: [0.0; 4],
            radius: [0.0; 4],
            distance,
            bound: [0.0; 4],
            children: [NONE; 4],
            first: parent.child(0),
        };
        for child in 0..4 {
            let radius = farthest(grid.of_child(child), centre[child]);
            family.set(child, centre[child], [distance[child], far[child], radius], bound);
        }
        family
    }

    /// Sets a cell by its squared distances: of the centre from the nearest site, the least one of
    /// a site from its farthest corner, and of the centre from the farthest corner.
    fn set(&mut self, index: usize, centre: DVec3, squared: [f64; 3], bound: f64) {
        // A ball that contains the corners contains the chords between them.
        let sagitta = self.place(index).sagitta();
        let [distance, far, radius] = squared.map(f64::sqrt);
        let radius = radius + sagitta;
        [self.x[index], self.y[index], self.z[index]] = centre.to_array();
        self.radius[index] = radius;
        self.distance[index] = distance;
        self.bound[index] = bound.min(far + sagitta).min(distance + radius);
    }

    fn place(&self, index: usize) -> CellPlace {
        let CellPlace { face, level, ix, iy } = self.first;
        let (face_offset, u, v) = Self::OFFSETS[index];
        match level {
            0 => CellPlace::root(face + face_offset),
            _ => CellPlace { face, level, ix: ix + u, iy: iy + v },
        }
    }

    /// Returns one of the four cells.
    pub(super) fn cell(&self, index: usize) -> FamilyCell {
        FamilyCell {
            place: self.place(index),
            centre: self.centre(index),
            radius: self.radius[index],
            distance: self.distance[index],
            bound: self.bound[index],
            children: self.children[index],
        }
    }

    pub(super) fn level(&self) -> u8 {
        self.first.level
    }

    fn centre(&self, index: usize) -> DVec3 {
        DVec3::new(self.x[index], self.y[index], self.z[index])
    }

    pub(super) fn bound(&self, index: usize) -> f64 {
        self.bound[index]
    }

    pub(super) fn children(&self, index: usize) -> u32 {
        self.children[index]
    }

    pub(super) fn set_children(&mut self, index: usize, children: u32) {
        self.children[index] = children;
    }

    /// Returns whether no cell is divided.
    pub(super) fn has_leaves_only(&self) -> bool {
        self.children == [NONE; 4]
    }

    /// Returns the distances of the centres from a new site, or infinity for cells without points
    /// that are nearer to it than to all other sites.
    #[inline]
    pub(super) fn approach(&self, site: DVec3) -> [f64; 4] {
        let mut distances = [0.0; 4];
        for (index, distance) in distances.iter_mut().enumerate() {
            let from_centre = site.distance(self.centre(index));
            let radius = self.radius[index];
            // At a point of the cell, at most a radius away, the other sites are nearer.
            let is_far = from_centre - radius >= self.distance[index] + radius;
            *distance = if is_far { f64::INFINITY } else { from_centre };
        }
        distances
    }

    /// Returns the distance and the bound of a cell with a new site that is at a distance of its
    /// centre.
    pub(super) fn with_site(&self, index: usize, distance: f64) -> (f64, f64) {
        let nearest = distance.min(self.distance[index]);
        (nearest, self.bound[index].min(nearest + self.radius[index]))
    }

    pub(super) fn set_bounds(&mut self, index: usize, (distance, bound): (f64, f64)) {
        (self.distance[index], self.bound[index]) = (distance, bound);
    }
}

/// The corners of the children of a cell in rows of three.
#[derive(Debug)]
pub(super) struct Corners([DVec3; 9]);

impl Corners {
    /// The four corners of each child.
    const OF_CHILDREN: [[usize; 4]; 4] = [[0, 1, 3, 4], [1, 2, 4, 5], [3, 4, 6, 7], [4, 5, 7, 8]];

    /// Returns those of a cell with these corners and centre.
    pub(super) fn new(cell: CellPlace, corners: [DVec3; 4], centre: DVec3) -> Self {
        let [south, east, west, north] = corners;
        let edges = [(0.5, 0.0), (0.0, 0.5), (1.0, 0.5), (0.5, 1.0)];
        let [south_east, south_west, north_east, north_west] = edges.map(|(u, v)| cell.point(u, v));
        let rows =
            [south, south_east, east, south_west, centre, north_east, west, north_west, north];
        Self(rows)
    }

    /// Returns the corners of a child.
    pub(super) fn of_child(&self, child: usize) -> [DVec3; 4] {
        Self::OF_CHILDREN[child].map(|at| self.0[at])
    }
}

/// Returns the squared distance of `p` from the farthest of four points.
fn farthest(corners: [DVec3; 4], p: DVec3) -> f64 {
    let [a, b, c, d] = corners.map(|corner| corner.distance_squared(p));
    a.max(b).max(c.max(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns all cells of a level.
    fn cells(level: u8) -> impl Iterator<Item = CellPlace> {
        let side = 1 << level;
        (0..12).flat_map(move |face| {
            (0..side * side).map(move |i| CellPlace { face, level, ix: i % side, iy: i / side })
        })
    }

    fn children(parent: CellPlace, bound: f64, sites: &[DVec3]) -> CellFamily {
        let corners = Corners::new(parent, parent.corners(), parent.point(0.5, 0.5));
        CellFamily::of_children(parent, &corners, bound, sites)
    }

    #[test]
    fn cells_lie_within_their_radius() {
        let roots = (0..12).step_by(4).map(|face| CellFamily::of_roots(face, 12, &[DVec3::Z]));
        let below = (0..=5).flat_map(cells).map(|parent| children(parent, 9.0, &[DVec3::Z]));
        for family in roots.chain(below) {
            for FamilyCell { place, centre, radius, .. } in [0, 1, 2, 3].map(|i| family.cell(i)) {
                let mut farthest: f64 = 0.0;
                for t in (0..=8).map(|t| f64::from(t) / 8.0) {
                    for (u, v) in [(t, 0.0), (t, 1.0), (0.0, t), (1.0, t)] {
                        farthest = farthest.max(place.point(u, v).distance(centre));
                    }
                }
                assert!(farthest < radius, "{place:?}: {farthest}, {radius}");
                // Small cells away from the poles have straight edges.
                let is_flat = place.level == 6 && place.face / 4 == 1;
                assert!(!is_flat || farthest > 0.98 * radius, "{place:?}: {farthest}, {radius}");
            }
        }
    }

    /// Shared corners, against every cell by itself; and every new site, against all sites at once.
    #[test]
    fn bounds_follow_their_definition() {
        let near_pole = DVec3::new(1e-9, 0.0, 1.0);
        let sites = [DVec3::Z, -DVec3::Z, near_pole, DVec3::X, DVec3::new(0.6, 0.0, 0.8)];
        for parent in (0..=3).flat_map(cells) {
            for bound in [0.3, 9.0] {
                let family = children(parent, bound, &sites);
                for index in [0, 1, 2, 3] {
                    let cell = family.cell(index);
                    let place = parent.child([0, 1, 2, 3][index]);
                    let centre = place.point(0.5, 0.5);
                    let farthest = |p: DVec3| {
                        place.corners().iter().map(|c| c.distance_squared(p)).fold(0.0, f64::max)
                    };
                    let radius = farthest(centre).sqrt() + place.sagitta();
                    let min_of =
                        |f: &dyn Fn(DVec3) -> f64| sites.map(f).into_iter().fold(9.0, f64::min);
                    let distance = min_of(&|p| p.distance_squared(centre)).sqrt();
                    let far = min_of(&|p| farthest(p)).sqrt() + place.sagitta();
                    let limit = bound.min(far).min(distance + radius);
                    assert_eq!(
                        [radius, distance, limit].map(f64::to_bits),
                        [cell.radius, cell.distance, cell.bound].map(f64::to_bits)
                    );
                    assert_eq!(cell.centre, centre);
                }
                let (last, others) = sites.split_last().unwrap();
                let before = children(parent, bound, others);
                for (index, near) in before.approach(*last).into_iter().enumerate() {
                    let (cell, after) = (before.cell(index), family.cell(index));
                    if near < f64::INFINITY {
                        let (distance, _) = before.with_site(index, near);
                        assert_eq!(near.to_bits(), last.distance(cell.centre).to_bits());
                        assert_eq!(distance.to_bits(), after.distance.to_bits());
                    } else {
                        // The site is nowhere in the cell the nearest one.
                        assert_eq!(cell.distance.to_bits(), after.distance.to_bits());
                    }
                }
            }
        }
    }
}
