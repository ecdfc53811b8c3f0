use std::fmt::Debug;

use pulp::Arch;
use rand::Rng;

use crate::vector::Vector;

/// A space of mass points that are assigned to sites, with points of D coordinates.
///
/// Mass points are stored by coordinate; a block holds the coordinates of those of one site.
pub(crate) trait MassSpace<const D: usize>: Copy + Debug {
    type Point: Vector;

    /// The area, which the sites share.
    const AREA: f64;

    /// An upper bound on every [`Self::distance`].
    const DIAMETER: f64;

    /// The minimum reduction of the sum of squared distances by an exchange, times the number of
    /// sites: 1e-12 of the area.
    const TOLERANCE: f64;

    /// Squared distances that differ by less than this count as equal.
    const ROUNDING: f64;

    fn coordinates(point: Self::Point) -> [f64; D];

    fn point(coordinates: [f64; D]) -> Self::Point;

    /// Returns the distance in which balls are measured: a metric that grows with the geodesic
    /// distance and does not exceed it.
    fn distance(self, a: Self::Point, b: Self::Point) -> f64;

    /// Returns a point near the middle of some sites, at best one from which they are not far.
    fn middle(self, sites: &[Self::Point]) -> Self::Point;

    /// Returns the first position of the site of these mass points.
    fn start(self, cell: &[Self::Point]) -> Self::Point;

    /// Returns the point at the end of a step, a tangent vector, from a site.
    fn moved(self, site: Self::Point, step: Self::Point) -> Self::Point;

    /// Returns a uniform point.
    fn random_point(self, rng: &mut dyn Rng) -> Self::Point;

    /// Brings mass points to the images by which [`Self::cut`] divides them.
    fn prepare(self, points: &mut [Self::Point], rng: &mut dyn Rng);

    /// Returns a random direction along which to divide a region whose points have this mean.
    fn cut(self, mean: Self::Point, rng: &mut dyn Rng) -> Self::Point;

    /// Writes d(p, own)^2 - d(p, other)^2 for each point p of the block to `reductions`, and
    /// returns the largest. `max_square` bounds the squares of [`Self::distance`].
    fn reductions_into(
        self,
        arch: Arch,
        block: [&[f64]; D],
        own: Self::Point,
        other: Self::Point,
        max_square: f64,
        reductions: &mut [f64],
    ) -> f64;

    /// Returns the moments of the points of the block about a site. `max_square` bounds the squares
    /// of [`Self::distance`].
    fn moments(
        self,
        arch: Arch,
        block: [&[f64]; D],
        site: Self::Point,
        max_square: f64,
    ) -> Moments<Self::Point>;
}

/// Moments of the mass points of a site.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments<P> {
    /// Sum of the logarithms of the points, tangent vectors at the site that lead to the points.
    pub(crate) sum: P,
    /// Largest square of [`MassSpace::distance`] from the site to a point.
    pub(crate) max_square: f64,
    /// Sum of the squared geodesic distances from the site to the points.
    pub(crate) energy: f64,
}
