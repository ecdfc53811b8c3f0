//! Quadrature rules: fixed nodes and weights that are exact up to a degree.

use std::f64::consts::TAU;
use std::fmt::Debug;

use glam::DVec3;
use rand::Rng;

use crate::{Domain, Error, PointSet, Sampler, SetDistribution};

/// A quadrature rule: a pattern that is not random, with an exact degree.
///
/// Every rule is a [`Sampler`].
pub trait Rule: Debug + Send + Sync {
    /// Returns the domain of the nodes.
    fn node_domain(&self) -> Domain;

    /// Returns the number of nodes on the domain.
    fn n_nodes(&self) -> usize;

    /// Returns the largest degree t such that the rule integrates all harmonics of degrees up to t
    /// on the sphere, and some of degree t + 1 not.
    fn exact_degree(&self) -> usize;

    /// Appends nodes and, unless all are equal, weights whose sum is the area of the domain. On the
    /// hemisphere, they integrate functions of even degree as the rule of the sphere does.
    ///
    /// # Errors
    ///
    /// [`Error`] if the nodes cannot be computed.
    fn nodes(&self, set: &mut PointSet) -> Result<(), Error>;
}

impl<R: Rule> Sampler for R {
    fn n_points(&self) -> usize {
        self.n_nodes()
    }

    fn domain(&self) -> Domain {
        self.node_domain()
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn last_empty_degree(&self) -> Option<usize> {
        let exact = self.exact_degree();
        Some(exact - exact % self.node_domain().degree_step())
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        set.start();
        self.nodes(set)
    }
}

/// Returns the size of a rule in a range, for constructors.
///
/// # Errors
///
/// [`Error::Parameter`] outside 1 to [`MAX_SIZE`].
pub(crate) fn checked_size(name: &'static str, size: u32) -> Result<u32, Error> {
    let is_valid = (1..=MAX_SIZE).contains(&size);
    let range = "a whole number from 1 to 32768";
    is_valid.then_some(size).ok_or(Error::Parameter { name, range, got: f64::from(size) })
}

/// The largest number of rings, frequency or number of cells along an edge of a rule: its numbers of
/// points, up to 10^10, and products of indices stay in range.
pub(crate) const MAX_SIZE: u32 = 1 << 15;

/// Returns whether a node of an antipodally symmetric rule belongs to the domain: on the hemisphere
/// one of each pair does, also on the equator.
pub(crate) fn is_kept(domain: Domain, p: DVec3) -> bool {
    let is_first = p.y > 0.0 || (p.y >= 0.0 && p.x > 0.0);
    domain == Domain::Sphere || p.z > 0.0 || (p.z >= 0.0 && is_first)
}

/// A ring of equally spaced nodes of equal weight, the first at longitude 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    /// The sine of the colatitude.
    pub(crate) sin: f64,
    /// The cosine of the colatitude, exactly 0 at the equator.
    pub(crate) cos: f64,
    /// The number of nodes; one at a pole.
    pub(crate) n_nodes: u32,
    /// The weight of each node.
    pub(crate) weight: f64,
}

impl Ring {
    /// Appends the nodes; on the hemisphere those below the equator are replaced by their
    /// antipodes.
    pub(crate) fn append(self, domain: Domain, set: &mut PointSet) {
        self.append_first(self.n_nodes, domain, set);
    }

    /// Appends the nodes of an antipodally symmetric rule with even rings; on the hemisphere one of
    /// each pair.
    pub(crate) fn append_half(self, domain: Domain, set: &mut PointSet) {
        if domain == Domain::Sphere || self.cos > 0.0 {
            self.append(domain, set);
        } else if self.cos >= 0.0 {
            self.append_first(self.n_nodes / 2, domain, set);
        }
    }

    fn append_first(self, n_nodes: u32, domain: Domain, set: &mut PointSet) {
        set.points.extend((0..n_nodes).map(|j| {
            let (y, x) = (TAU * f64::from(j) / f64::from(self.n_nodes)).sin_cos();
            domain.representative(DVec3::new(self.sin * x, self.sin * y, self.cos))
        }));
        set.weights.resize(set.points.len(), self.weight);
    }
}

/// Sines of the multiples of `pi/n`, by index modulo `2n`.
pub(crate) struct Sines {
    table: Box<[f64]>,
}

impl Sines {
    /// Returns the sines of `j pi/n`, accurate to rounding for every j.
    pub(crate) fn new(n: usize) -> Self {
        // Angles up to a right angle, from which the others follow without rounding.
        let acute = |j: usize| (TAU * j as f64 / (2 * n) as f64).sin();
        let upper = |j: usize| acute(j.min(n - j));
        let table = (0..2 * n).map(|j| if j <= n { upper(j) } else { -upper(j - n) }).collect();
        Self { table }
    }

    /// Returns `sin(j pi/n)`.
    pub(crate) fn sin(&self, j: usize) -> f64 {
        self.table[j % self.table.len()]
    }

    /// Returns `cos(j pi/n)` for even n; use [`Self::new`] of twice the number for odd n.
    pub(crate) fn cos(&self, j: usize) -> f64 {
        self.sin(j + self.table.len() / 4)
    }
}
