use std::f64::consts::SQRT_2;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::sphere_cells::SphereCells;
use super::{DiskMode, PoissonDisk};
use crate::disks::{End, decreasing_into};
use crate::{Domain, Error, PointSet, Progress, Sampler};

/// Poisson disk points of decreasing radius: dart throwing with large disks until no further one
/// fits, then with a radius that is 1 % smaller, and so on.
///
/// Every prefix is evenly spread, and the first points are the farthest apart. [`DiskMode::Exact`] ends at N points, with a minimum distance of about
/// 2.9/sqrt(N); [`DiskMode::Saturated`] ends at the radius [`Self::chord`], when no region is free,
/// with about N points for the default radius. No two points are nearer than that radius.
///
/// The power at low degrees is 0.08, more than that of dart throwing.
///
/// The radii are those of the smallest disks times powers of 1/0.99, up to the diameter of the
/// sphere. The cost is some 40 times that of dart throwing.
///
/// ```
/// use sphvar_samplers::{DecreasingPoissonDisk, DiskMode, Domain, Purpose, Sampler, Streams};
///
/// let disks = DecreasingPoissonDisk::new(100, Domain::Sphere, DiskMode::Exact, None)?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 100).realization(0);
/// let points = disks.sample(&mut rng)?.points;
/// // The first points are far apart.
/// assert!(points.len() == 100 && points[1].distance(points[0]) > 1.9);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// McCool and Fiume 1992, Proc. Graphics Interface, 94.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecreasingPoissonDisk {
    disks: PoissonDisk,
}

impl DecreasingPoissonDisk {
    /// The default radius of exact sets, at which they always have N points: caps of this radius
    /// cover the sphere only if there are N of them. Sets are complete at radii of 2.6 to 3.
    pub const EXACT_RADIUS: f64 = 2.0;

    /// The default radius of saturated sets: they have about N points.
    pub const SATURATED_RADIUS: f64 = 2.886;

    /// Nominal work per point.
    const WORK_PER_POINT: f64 = 1500.0;

    /// Ticks of a set, about: the levels to which cells are divided, for all radii.
    const DEFAULT_TICKS: f64 = 3000.0;

    /// Returns the pattern of `n_points` points on `domain`, for saturated sets the number expected
    /// with the default radius; `radius`, in the units of [`PoissonDisk`], is that of the smallest
    /// disks.
    ///
    /// # Errors
    ///
    /// Those of [`PoissonDisk::new`].
    pub fn new(
        n_points: usize,
        domain: Domain,
        mode: DiskMode,
        radius: Option<f64>,
    ) -> Result<Self, Error> {
        let default = match mode {
            DiskMode::Exact => Self::EXACT_RADIUS,
            DiskMode::Saturated => Self::SATURATED_RADIUS,
        };
        let radius = Some(radius.unwrap_or(default));
        Ok(Self { disks: PoissonDisk::new(n_points, domain, mode, radius)? })
    }

    /// Returns the chord of the smallest disks, a lower bound of the distance of two points and, on
    /// the hemisphere, of a point and the antipode of another.
    #[must_use]
    pub fn chord(&self) -> f64 {
        self.disks.chord()
    }

    fn space(&self, chord: f64, points: &[DVec3]) -> SphereCells {
        let expected = self.disks.saturated_count().min(self.disks.n_points as f64);
        let mut cells = SphereCells::new(self.disks.domain, chord, expected);
        points.iter().for_each(|&point| cells.insert_at(point));
        cells
    }
}

impl Sampler for DecreasingPoissonDisk {
    /// Returns the requested number of points; a saturated set has approximately that number.
    fn n_points(&self) -> usize {
        self.disks.n_points
    }

    fn domain(&self) -> Domain {
        self.disks.domain
    }

    fn nominal_work(&self) -> f64 {
        Self::WORK_PER_POINT * self.n_points() as f64
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
        let mut own = ChaCha8Rng::from_rng(rng);
        // Each level subdivides a few times.
        let level = self.nominal_work() / Self::DEFAULT_TICKS;
        let tick = || progress.tick(level);
        let limit = match self.disks.mode {
            DiskMode::Exact => self.disks.n_points,
            DiskMode::Saturated => usize::MAX,
        };
        let largest = match self.disks.domain {
            Domain::Sphere => 2.0,
            Domain::Hemisphere => SQRT_2,
        };
        let radii = (largest, self.chord());
        let space = |chord, points: &[DVec3]| self.space(chord, points);
        let end = decreasing_into(limit, radii, space, &mut own, points, &tick)?;
        if end != End::Full && self.disks.mode == DiskMode::Exact {
            let (radius, placed) = (self.disks.radius, points.len());
            points.clear();
            return Err(self.disks.infeasible(format!(
                "only {placed} disks fitted down to radius {radius}; the default radius is {}",
                Self::EXACT_RADIUS
            )));
        }
        Ok(())
    }
}
