mod free_point;
mod packing;
mod parameters;
mod square_cells;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::disks::{End, SequentialAddition, attempts, exact_into};
use crate::ensemble::progress::Tick;
use crate::{DiskMode, Error, PointSet, Progress, SquareSampler};
pub use free_point::free_point;
pub(crate) use packing::greatest_distance;
pub use parameters::PoissonDiskSquareParameters;
use square_cells::SquareCells;

const NAME: &str = "poisson-disk-square";

/// Poisson disk points of the square by dart throwing (random sequential addition): points are
/// placed one after the other, each uniformly in the region outside the disks around all previous
/// points.
///
/// The disks have the radius `radius/sqrt(N)`, so that no two points are nearer than that. With
/// *wrapped* distances opposite sides of the square are joined: the set continues periodically, and
/// its distribution is invariant under toroidal shifts. Without, disks end at the sides; points
/// accumulate there, and the set has power along both axes of the frequency plane near 0 (0.3 to
/// 0.4, against 0.06 elsewhere; Figure 4.3 of the thesis).
///
/// [`DiskMode::Exact`] stops at N points; a set that is full earlier is discarded and restarted
/// with the next random numbers, at most `16 + 100000/N` attempts in total.
/// [`DiskMode::Saturated`] continues until no free region remains except in cells of 1e-18 of the
/// square whose total area is below 1e-12; the number of points is random, with mean
/// `0.6965 N/radius^2` for wrapped distances. [`free_point`] tests any set.
///
/// The points are in the order of their placement, so the first K of them are K disks of the same
/// distribution (for an exact set, conditional on the placement of N points).
///
/// ```
/// use sphvar_samplers::{DiskMode, PoissonDiskSquare, Purpose, SquareSampler, Streams, free_point};
///
/// let disks = PoissonDiskSquare::new(100, DiskMode::Saturated, true, None)?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 100).realization(0);
/// let points = disks.sample(&mut rng)?.points;
/// assert!((80..120).contains(&points.len()));
/// assert_eq!(free_point(&points, disks.distance(), true)?, None);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// Cook 1986, ACM Trans. Graph. 5, 51, for dart throwing; White, Cline and Egbert 2007 (IEEE Symp.
/// Interactive Ray Tracing, 129) and Gamito and Maddock 2009 (ACM Trans. Graph. 29, 8) for the
/// subdivision of the free region; Feder 1980, J. Theor. Biol. 87, 237, for the share 0.547 that
/// disks of half the radius fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoissonDiskSquare {
    n_points: usize,
    mode: DiskMode,
    is_wrapped: bool,
    radius: f64,
}

impl PoissonDiskSquare {
    /// The default radius of exact sets: the density of the disks is that of the sphere's, so for
    /// N >= 768 a set is practically never full before it has N points.
    pub const EXACT_RADIUS: f64 = 0.816;

    /// The default radius of saturated sets with wrapped distances, `sqrt(4 * 0.547/pi)`: they have
    /// N points on average.
    pub const SATURATED_RADIUS: f64 = 0.8346;

    /// The largest valid number of points; more would exceed the range of 32-bit indices.
    pub const MAX_POINTS: usize = 1 << 29;

    /// The fraction of the largest possible distance that default radii of few points do not
    /// exceed.
    const PACKING_SHARE: f64 = 0.95;

    /// The share of the square that may remain undecided in a saturated set.
    const UNRESOLVED_SHARE: f64 = 1e-12;

    /// The approximate number of subdivision levels after which an exact set is complete.
    const DEFAULT_LEVELS: f64 = 8.0;

    /// The extra width, in radii, of the square that saturated disks fill if its sides are not
    /// joined, because nothing excludes centres from outside; measured at N = 4096, and right to
    /// 1.5 % of the number of points at N = 16.
    const OVERHANG: f64 = 0.687;

    /// Returns the pattern of `n_points` points (for saturated sets, the number expected with the
    /// default radius), with disks of `radius/sqrt(n_points)` or, with `None`, of
    /// [`Self::default_radius`].
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points, [`Error::TooManyPoints`] above [`Self::MAX_POINTS`],
    /// [`Error::Infeasible`] if the radius is not a positive number, if `n_points` points cannot be
    /// that far apart, or if a saturated set would have more than [`Self::MAX_POINTS`] points.
    pub fn new(
        n_points: usize,
        mode: DiskMode,
        is_wrapped: bool,
        radius: Option<f64>,
    ) -> Result<Self, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: NAME.to_owned() });
        }
        if n_points > Self::MAX_POINTS {
            let max = Self::MAX_POINTS;
            return Err(Error::TooManyPoints { pattern: NAME, requested: n_points, max });
        }
        let default = Self::default_radius(n_points, mode, is_wrapped);
        let radius = radius.unwrap_or(default);
        let disks = Self { n_points, mode, is_wrapped, radius };
        if !(radius.is_finite() && radius > 0.0) {
            return Err(disks.infeasible(format!(
                "the radius must be a positive number such as {default:.4}, got {radius}"
            )));
        }
        let greatest = greatest_distance(n_points, is_wrapped);
        if mode == DiskMode::Exact && disks.distance() > greatest {
            return Err(disks.infeasible(format!(
                "radius {radius} requires a distance of {:.6}, but {n_points} points are at most \
                 {greatest:.6} apart (radius {:.4}); the default radius is {default:.4}",
                disks.distance(),
                greatest * disks.root_of_density(),
            )));
        }
        let expected = disks.saturated_count();
        if mode == DiskMode::Saturated && expected > Self::MAX_POINTS as f64 {
            return Err(disks.infeasible(format!(
                "with radius {radius} a saturated set has about {expected:.3e} points, more than \
                 {}; the radius must be at least {:.6}",
                Self::MAX_POINTS,
                radius * (expected / Self::MAX_POINTS as f64).sqrt()
            )));
        }
        Ok(disks)
    }

    /// Returns the default radius of [`Self::new`]: [`Self::SATURATED_RADIUS`], larger for
    /// distances that are not wrapped so that the mean number of points remains N; or
    /// [`Self::EXACT_RADIUS`], for few points at most 95 % of an upper bound on their distance.
    #[must_use]
    pub fn default_radius(n_points: usize, mode: DiskMode, is_wrapped: bool) -> f64 {
        let root = (n_points as f64).sqrt();
        match mode {
            // The solution of (SATURATED_RADIUS/r)^2 (1 + OVERHANG r)^2 = N, for r = radius/root.
            DiskMode::Saturated if !is_wrapped && n_points > 1 => {
                Self::SATURATED_RADIUS * root / (root - Self::OVERHANG * Self::SATURATED_RADIUS)
            }
            DiskMode::Saturated => Self::SATURATED_RADIUS,
            DiskMode::Exact => {
                let packed = greatest_distance(n_points, is_wrapped) * root;
                Self::EXACT_RADIUS.min(Self::PACKING_SHARE * packed)
            }
        }
    }

    /// Returns the criterion by which a set is complete.
    #[must_use]
    pub fn mode(&self) -> DiskMode {
        self.mode
    }

    /// Returns whether distances are toroidal.
    #[must_use]
    pub fn is_wrapped(&self) -> bool {
        self.is_wrapped
    }

    /// Returns the radius of the disks in units of `1/sqrt(N)`.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the minimum distance between two points.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.radius / self.root_of_density()
    }

    fn root_of_density(&self) -> f64 {
        (self.n_points as f64).sqrt()
    }

    /// Returns the approximate number of points of a saturated set.
    fn saturated_count(&self) -> f64 {
        let overhang = if self.is_wrapped { 0.0 } else { Self::OVERHANG };
        let per_side = Self::SATURATED_RADIUS * (1.0 / self.distance() + overhang);
        per_side * per_side
    }

    fn infeasible(&self, reason: String) -> Error {
        Error::Infeasible { pattern: NAME, n_points: self.n_points, reason }
    }

    fn exact_into(
        &self,
        rng: &mut ChaCha8Rng,
        points: &mut Vec<[f64; 2]>,
        tick: Tick<'_>,
    ) -> Result<(), Error> {
        let expected = self.saturated_count().min(self.n_points as f64);
        let space = || SquareCells::new(self.is_wrapped, self.distance(), expected);
        let placed = exact_into(self.n_points, space, rng, points, tick)?;
        if placed == self.n_points {
            return Ok(());
        }
        // The largest set had this radius in units of its own number of points; a slightly smaller
        // radius allows for chance.
        let possible = 0.98 * self.radius * (placed as f64 / self.n_points as f64).sqrt();
        let default = Self::default_radius(self.n_points, self.mode, self.is_wrapped);
        Err(self.infeasible(format!(
            "at most {placed} disks of radius {1} fitted in {0} attempts; a radius of {2:.3} is \
             possible",
            attempts(self.n_points),
            self.radius,
            possible.min(default)
        )))
    }

    fn saturated_into(
        &self,
        rng: &mut ChaCha8Rng,
        points: &mut Vec<[f64; 2]>,
        tick: Tick<'_>,
    ) -> Result<(), Error> {
        let space = SquareCells::new(self.is_wrapped, self.distance(), self.saturated_count());
        match SequentialAddition::new(space, rng).run(usize::MAX, points, tick)? {
            End::Saturated { unresolved } if unresolved > Self::UNRESOLVED_SHARE => {
                points.clear();
                Err(self.infeasible(format!(
                    "{unresolved:.1e} of the square could not be told to be covered; fewer points \
                     can be saturated"
                )))
            }
            _ => Ok(()),
        }
    }
}

impl SquareSampler for PoissonDiskSquare {
    /// Returns the requested number of points; a saturated set has approximately that number.
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn nominal_work(&self) -> f64 {
        40.0 * self.n_points as f64
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        // A local generator: a `dyn` call for every number costs as much as a candidate.
        let mut own = ChaCha8Rng::from_rng(rng);
        let level = self.nominal_work() / Self::DEFAULT_LEVELS;
        match self.mode {
            DiskMode::Exact => self.exact_into(&mut own, points, &|| progress.tick(level)),
            DiskMode::Saturated => self.saturated_into(&mut own, points, &|| progress.tick(level)),
        }
    }
}
