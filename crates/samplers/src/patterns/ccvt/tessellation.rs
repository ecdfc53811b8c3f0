use glam::DVec3;

use super::relaxation::Relaxation;
use crate::Domain;

/// A capacity-constrained Voronoi tessellation: sites, each with its own mass points.
///
/// Created by [`Ccvt::tessellate`](crate::Ccvt::tessellate).
#[derive(Clone, Debug)]
pub struct Tessellation {
    pub(super) relaxation: Relaxation,
    pub(super) domain: Domain,
    pub(super) passes: usize,
    pub(super) is_settled: bool,
}

impl Tessellation {
    /// Returns the sites, with z >= 0 on the hemisphere.
    #[must_use]
    pub fn sites(&self) -> Vec<DVec3> {
        let mut sites = Vec::new();
        self.sites_into(&mut sites);
        sites
    }

    pub(super) fn sites_into(&self, sites: &mut Vec<DVec3>) {
        sites.clear();
        sites.extend(self.relaxation.sites().iter().map(|&s| self.domain.representative(s)));
    }

    /// Returns the `capacity` mass points of site `k`; on the hemisphere up to sign.
    ///
    /// # Panics
    ///
    /// Panics if `k` is not the index of a site.
    pub fn cell(&self, k: usize) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        self.relaxation.cell(k)
    }

    /// Returns the normalized energy: the number of sites times the mean squared geodesic distance
    /// (radians) from a mass point to its site.
    ///
    /// In the limit of large capacities no tessellation has a lower energy than regular hexagons,
    /// 10 pi/(9 sqrt 3) = 2.015 on the sphere and half of that on the hemisphere, whose cells have
    /// half the area.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.relaxation.energy()
    }

    /// Returns the number of passes over the neighbouring pairs of sites.
    #[must_use]
    pub fn passes(&self) -> usize {
        self.passes
    }

    /// Returns whether no exchange between two sites lowers the energy; `false` if the limit of
    /// passes was reached first.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.is_settled
    }
}
