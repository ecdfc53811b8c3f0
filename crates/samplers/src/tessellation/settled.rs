use glam::DVec3;

/// A capacity-constrained Voronoi tessellation: sites, each with its own mass points.
///
/// Created by [`Ccvt::tessellate`](crate::Ccvt::tessellate) and
/// [`CcvtSquare::tessellate`](crate::CcvtSquare::tessellate).
#[derive(Clone, Debug)]
pub struct Tessellation<P = DVec3> {
    pub(super) sites: Vec<P>,
    /// Those of each site in turn.
    pub(super) mass_points: Vec<P>,
    pub(super) energy: f64,
    pub(super) passes: usize,
    pub(super) is_settled: bool,
}

impl<P: Copy> Tessellation<P> {
    /// Returns the sites, with z >= 0 on the hemisphere.
    #[must_use]
    pub fn sites(&self) -> Vec<P> {
        self.sites.clone()
    }

    /// Returns the `capacity` mass points of site `k`; on the hemisphere up to sign.
    ///
    /// # Panics
    ///
    /// Panics if `k` is not the index of a site.
    pub fn cell(&self, k: usize) -> impl ExactSizeIterator<Item = P> + '_ {
        let capacity = self.mass_points.len() / self.sites.len();
        self.mass_points[k * capacity..(k + 1) * capacity].iter().copied()
    }

    /// Returns the normalized energy: the number of sites times the mean squared geodesic distance
    /// (radians; on the square turns) from a mass point to its site.
    ///
    /// In the limit of large capacities no tessellation has a lower energy than regular hexagons,
    /// 10 pi/(9 sqrt 3) = 2.015 on the sphere, half of that on the hemisphere, whose cells have
    /// half the area, and 5/(18 sqrt 3) = 0.1604 on the square.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.energy
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
