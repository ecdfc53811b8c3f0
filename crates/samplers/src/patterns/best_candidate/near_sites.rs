use glam::DVec3;
use sphvar_healpix::Cell;

use crate::Domain;
use crate::search::{CubeGrid, Grid};

/// The distance within which sites are found in neighbouring cells, over the clearance of the last
/// point. It covers 97 % of the searches.
const REACH: f64 = 1.6;

/// The decrease of the clearance after which the cells are made smaller.
const SHRUNK: f64 = 0.8;

/// The points of a growing set, on the hemisphere with their antipodes, and grids that find those
/// near a direction.
#[derive(Debug)]
pub(super) struct NearSites {
    domain: Domain,
    points: Vec<DVec3>,
    /// Finds sites within `reach`, with a third of the cells of the other grid to visit.
    grid: Grid,
    reach: f64,
    /// The clearance that the grid was made for.
    clearance: f64,
    /// Finds sites at every distance.
    cube: CubeGrid,
    /// The number of sites at which the cube is replaced.
    crowded_at: usize,
}

impl NearSites {
    pub(super) fn new(domain: Domain, clearance: f64) -> Self {
        Self {
            domain,
            points: Vec::new(),
            grid: Grid::new(Domain::Sphere, 2.0, 1.0),
            reach: 2.0,
            clearance,
            cube: CubeGrid::for_points(1),
            crowded_at: 1,
        }
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Adds a point, and on the hemisphere its antipode.
    pub(super) fn add(&mut self, point: DVec3) {
        self.add_site(point);
        if self.domain == Domain::Hemisphere {
            self.add_site(-point);
        }
    }

    fn add_site(&mut self, site: DVec3) {
        self.points.push(site);
        self.grid.insert(self.place(site), site);
        if self.points.len() >= self.crowded_at {
            self.crowded_at = 2 * self.points.len();
            self.cube = CubeGrid::for_points(self.crowded_at);
            self.points.iter().for_each(|&p| self.cube.insert(p));
        } else {
            self.cube.insert(site);
        }
    }

    /// Makes the cells fit distances of about the clearance of the last point.
    pub(super) fn adapt(&mut self, clearance: f64) {
        if clearance >= SHRUNK * self.clearance {
            return;
        }
        self.clearance = clearance;
        self.reach = REACH * clearance;
        self.grid = Grid::new(Domain::Sphere, self.reach, self.points.len() as f64);
        for index in 0..self.points.len() {
            let site = self.points[index];
            self.grid.insert(self.place(site), site);
        }
    }

    fn place(&self, p: DVec3) -> u32 {
        self.grid.place(Cell::containing(self.grid.nside(), p))
    }

    /// Returns the squared distance of `p` from the nearest site, or `None` if it does not exceed
    /// `bound`.
    pub(super) fn clearance(&self, p: DVec3, bound: f64) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        for site in self.grid.near(self.place(p)) {
            nearest = nearest.min(site.distance_squared(p));
            if nearest <= bound {
                return None;
            }
        }
        if nearest <= self.reach * self.reach {
            return Some(nearest);
        }
        self.cube.clearance(&self.points, p, bound)
    }

    /// Appends the sites within a distance of `p`.
    pub(super) fn gather(&self, p: DVec3, distance: f64, near: &mut Vec<DVec3>) {
        if distance > self.reach {
            return self.cube.gather(&self.points, p, distance, near);
        }
        let sites = self.grid.near(self.place(p));
        near.extend(sites.filter(|site| site.distance_squared(p) <= distance * distance));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pattern, Purpose, Streams};

    /// Sites all over the sphere and in a cluster, at reaches from far too small to too large.
    #[test]
    fn searches_match_an_exhaustive_one() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        let mut sample = |n| {
            let pattern = Pattern::WhiteNoise.build(n, Domain::Sphere).unwrap();
            pattern.sample(&mut rng).unwrap().points
        };
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for spread in [1.0, 1e-7] {
                let points = sample(150);
                let mut sites = NearSites::new(domain, 2.0);
                let mut all = Vec::new();
                for (k, p) in points.into_iter().enumerate() {
                    let p = (DVec3::new(0.6, 0.0, 0.8) + spread * p).normalize();
                    sites.add(p);
                    all.push(p);
                    if domain == Domain::Hemisphere {
                        all.push(-p);
                    }
                    if k % 50 == 20 {
                        sites.adapt([0.5, 0.1, 0.0][k / 50]);
                    }
                }
                assert_eq!(sites.points(), all);
                for p in sample(40) {
                    let nearest = all.iter().map(|q| q.distance_squared(p));
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    assert_eq!(sites.clearance(p, -1.0), Some(nearest), "{domain} {spread} {p}");
                    assert_eq!(sites.clearance(p, nearest), None, "{domain} {spread} {p}");
                    for distance in [0.0, 0.15, 0.7, 2.1] {
                        let mut near = Vec::new();
                        sites.gather(p, distance, &mut near);
                        let is_near = |q: &&DVec3| q.distance_squared(p) <= distance * distance;
                        assert_eq!(near.len(), all.iter().filter(is_near).count());
                    }
                }
            }
        }
    }
}
