mod boundary;
mod decreasing;
mod mode;
mod packing;
mod parameters;
mod placement;
mod quarters;
mod sphere_cells;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::disks::{End, SequentialAddition, attempts, exact_into};
use crate::ensemble::progress::Tick;
use crate::{Domain, Error, PointSet, Progress, Sampler};
pub use boundary::BoundaryPoissonDisk;
pub use decreasing::DecreasingPoissonDisk;
pub use mode::DiskMode;
pub(crate) use packing::greatest_chord;
pub use parameters::PoissonDiskParameters;
pub use placement::DiskPlacement;
use sphere_cells::SphereCells;

const NAME: &str = "poisson-disk";

/// Poisson disk points by dart throwing (random sequential addition): points are placed one after
/// the other, each uniformly in the region outside the disks around all previous points.
///
/// The disks have the chord radius
///
/// ```text
/// r = radius / sqrt(N)     on the sphere
/// r = radius / sqrt(2 N)   on the hemisphere, where the distance of x and y is
///                          min(|x - y|, |x + y|): the same density
/// ```
///
/// so that no two points are nearer than r. [`DiskMode::Exact`] stops at N points; a set that is
/// full earlier is discarded and restarted with the next random numbers, at most `16 + 100000/N`
/// attempts in total. [`DiskMode::Saturated`] continues until no free region remains except in
/// cells of 1.5e-17 steradian whose total area is below 1e-12 of the domain (about 20 cells at N =
/// 10^6, none at N = 10^4); the number of points is random, with mean `8.752 N / radius^2` and
/// variance 0.058 times that. For small N the mean is slightly smaller: 0.97 N at N = 12, 0.996 N
/// at 108.
///
/// The points are in the order of their placement, so the first K of them are K disks of the same
/// distribution (for an exact set, conditional on the placement of N points).
///
/// The cost is about 2.4 microseconds per point at N = 4096 and 3.7 at N = 10^6, where memory
/// access is slower, and some 190 bytes of memory per point.
///
/// ```
/// use sphvar_samplers::{DiskMode, Domain, PoissonDisk, Purpose, Sampler, Streams};
///
/// let disks = PoissonDisk::new(100, Domain::Sphere, DiskMode::Exact, None)?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 100).realization(0);
/// let points = disks.sample(&mut rng)?.points;
/// assert_eq!(points.len(), 100);
/// let nearest = points[1..].iter().map(|p| p.distance(points[0])).fold(2.0, f64::min);
/// assert!(nearest >= disks.chord() && disks.chord() == 0.2893);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// Cook 1986, ACM Trans. Graph. 5, 51, for dart throwing; White, Cline and Egbert 2007 (IEEE Symp.
/// Interactive Ray Tracing, 129) and Gamito and Maddock 2009 (ACM Trans. Graph. 29, 8) for the
/// subdivision of the free region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoissonDisk {
    n_points: usize,
    domain: Domain,
    mode: DiskMode,
    radius: f64,
}

impl PoissonDisk {
    /// The default radius of exact sets, 2.893: for N >= 768 a set is practically never full before
    /// it has N points; for N = 12 every fifth set is.
    pub const EXACT_RADIUS: f64 = 2.893;

    /// The default radius of saturated sets, 2.958: they have N points on average.
    pub const SATURATED_RADIUS: f64 = 2.958;

    /// The largest valid number of points; more would exceed the range of 32-bit indices.
    pub const MAX_POINTS: usize = 1 << 29;

    /// The fraction of the largest possible chord that default radii of few points do not exceed.
    const PACKING_SHARE: f64 = 0.95;

    /// The share of the domain's area that may remain undecided in a saturated set.
    const UNRESOLVED_SHARE: f64 = 1e-12;

    /// The approximate number of subdivision levels after which an exact set is complete.
    const DEFAULT_LEVELS: f64 = 8.0;

    /// The share of the sphere, M r^2/16, that saturated disks of radius r/2 fill.
    const SATURATED_FILL: f64 = 0.547;

    /// Returns the pattern of `n_points` points on `domain` (for saturated sets, the number
    /// expected with the default radius), with disks of `radius` in the units above or, with
    /// `None`, of [`Self::default_radius`].
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points, [`Error::TooManyPoints`] above [`Self::MAX_POINTS`],
    /// [`Error::Infeasible`] if the radius is not a positive number, if `n_points` points cannot be
    /// that far apart, or if a saturated set would have more than [`Self::MAX_POINTS`] points.
    pub fn new(
        n_points: usize,
        domain: Domain,
        mode: DiskMode,
        radius: Option<f64>,
    ) -> Result<Self, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: NAME.to_owned() });
        }
        if n_points > Self::MAX_POINTS {
            let max = Self::MAX_POINTS;
            return Err(Error::TooManyPoints { pattern: NAME, requested: n_points, max });
        }
        let radius = radius.unwrap_or_else(|| Self::default_radius(n_points, domain, mode));
        let disks = Self { n_points, domain, mode, radius };
        if !(radius.is_finite() && radius > 0.0) {
            return Err(disks.infeasible(format!(
                "the radius must be a positive number such as {}, got {radius}",
                disks.own_default_radius()
            )));
        }
        let greatest = greatest_chord(n_points, domain);
        if mode == DiskMode::Exact && disks.chord() > greatest {
            return Err(disks.infeasible(format!(
                "radius {radius} requires a distance of {2:.6}, but {n_points} points are at most \
                 {greatest:.6} apart (radius {0:.4}); the default radius is {1:.4}",
                greatest * disks.root_of_density(),
                disks.own_default_radius(),
                disks.chord()
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

    /// Returns the default radius of [`Self::new`]: [`Self::SATURATED_RADIUS`] or
    /// [`Self::EXACT_RADIUS`]; for sets of two or three points, at most 95 % of the packing bound
    /// of Fejes Toth.
    #[must_use]
    pub fn default_radius(n_points: usize, domain: Domain, mode: DiskMode) -> f64 {
        match mode {
            DiskMode::Saturated => Self::SATURATED_RADIUS,
            DiskMode::Exact => {
                let packed =
                    greatest_chord(n_points, domain) * domain.count_on_sphere(n_points).sqrt();
                Self::EXACT_RADIUS.min(Self::PACKING_SHARE * packed)
            }
        }
    }

    /// Returns the criterion by which a set is complete.
    #[must_use]
    pub fn mode(&self) -> DiskMode {
        self.mode
    }

    /// Returns the radius of the disks in units of `1/sqrt(N)`, on the hemisphere of `1/sqrt(2 N)`.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the minimum chord between two points and, on the hemisphere, between a point and the
    /// antipode of another.
    #[must_use]
    pub fn chord(&self) -> f64 {
        self.radius / self.root_of_density()
    }

    fn own_default_radius(&self) -> f64 {
        Self::default_radius(self.n_points, self.domain, self.mode)
    }

    fn root_of_density(&self) -> f64 {
        self.domain.count_on_sphere(self.n_points).sqrt()
    }

    /// Returns the approximate number of points of a saturated set.
    fn saturated_count(&self) -> f64 {
        let on_sphere = 16.0 * Self::SATURATED_FILL / self.chord().powi(2);
        match self.domain {
            Domain::Sphere => on_sphere,
            Domain::Hemisphere => 0.5 * on_sphere,
        }
    }

    fn infeasible(&self, reason: String) -> Error {
        Error::Infeasible { pattern: NAME, n_points: self.n_points, reason }
    }

    fn exact_into(
        &self,
        rng: &mut ChaCha8Rng,
        points: &mut Vec<DVec3>,
        tick: Tick<'_>,
    ) -> Result<(), Error> {
        let expected = self.saturated_count().min(self.n_points as f64);
        let space = || SphereCells::new(self.domain, self.chord(), expected);
        let placed = exact_into(self.n_points, space, rng, points, tick)?;
        if placed == self.n_points {
            return Ok(());
        }
        // The largest set had this radius in units of its own number of points; a slightly smaller
        // radius allows for chance.
        let possible = 0.98 * self.radius * (placed as f64 / self.n_points as f64).sqrt();
        Err(self.infeasible(format!(
            "at most {placed} disks of radius {1} fitted in {0} attempts; a radius of {2:.3} is \
             possible",
            attempts(self.n_points),
            self.radius,
            possible.min(self.own_default_radius())
        )))
    }

    fn saturated_into(
        &self,
        rng: &mut ChaCha8Rng,
        points: &mut Vec<DVec3>,
        tick: Tick<'_>,
    ) -> Result<(), Error> {
        let space = SphereCells::new(self.domain, self.chord(), self.saturated_count());
        match SequentialAddition::new(space, rng).run(usize::MAX, points, tick)? {
            End::Saturated { unresolved }
                if unresolved > Self::UNRESOLVED_SHARE * self.domain.area() =>
            {
                points.clear();
                Err(self.infeasible(format!(
                    "{unresolved:.1e} steradian could not be told to be covered; fewer points \
                     can be saturated"
                )))
            }
            _ => Ok(()),
        }
    }
}

impl Sampler for PoissonDisk {
    /// Returns the requested number of points; a saturated set has approximately that number.
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn nominal_work(&self) -> f64 {
        40.0 * self.n_points as f64
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_radii_are_rejected() {
        for mode in [DiskMode::Exact, DiskMode::Saturated] {
            for radius in [f64::NAN, 0.0, -0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
                let rejected =
                    PoissonDisk::new(10, Domain::Sphere, mode, Some(radius)).unwrap_err();
                let message = rejected.to_string();
                assert!(
                    message.contains("positive") && message.contains("such as 2."),
                    "{message}"
                );
            }
        }
    }

    #[test]
    fn counts_beyond_the_indices_are_rejected() {
        for (n, domain) in [(0, Domain::Sphere), (0, Domain::Hemisphere)] {
            let rejected = PoissonDisk::new(n, domain, DiskMode::Exact, None).unwrap_err();
            assert!(matches!(rejected, Error::NoPoints { .. }));
        }
        for n in [PoissonDisk::MAX_POINTS + 1, usize::MAX] {
            let rejected = PoissonDisk::new(n, Domain::Sphere, DiskMode::Exact, None).unwrap_err();
            assert!(matches!(rejected, Error::TooManyPoints { .. }));
        }
        assert!(PoissonDisk::new(1 << 29, Domain::Sphere, DiskMode::Exact, None).is_ok());
        let tiny = |radius| PoissonDisk::new(1000, Domain::Sphere, DiskMode::Saturated, radius);
        for radius in [1e-3, 1e-150, f64::MIN_POSITIVE] {
            let message = tiny(Some(radius)).unwrap_err().to_string();
            assert!(message.contains("at least"), "{message}");
        }
    }

    #[test]
    fn impossible_packings_are_rejected_at_once() {
        for (n, domain, valid, too_large) in [
            (2, Domain::Sphere, 2.0, 2.0001),
            (12, Domain::Sphere, 1.0514, 1.0515),
            (2, Domain::Hemisphere, 1.41, 1.42),
        ] {
            let scale = domain.count_on_sphere(n).sqrt();
            let with =
                |chord: f64| PoissonDisk::new(n, domain, DiskMode::Exact, Some(chord * scale));
            assert!(with(valid).is_ok(), "{n} {domain} {valid}");
            let message = with(too_large).unwrap_err().to_string();
            assert!(message.contains("apart"), "{message}");
        }
    }
}
