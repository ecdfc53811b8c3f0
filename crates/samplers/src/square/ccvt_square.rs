mod mass;
mod torus;

use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

pub use self::mass::SquareMassPoints;
pub(crate) use self::torus::Torus;

use crate::definition::Definition;
use crate::tessellation::{
    MAX_PASSES, Relaxation, check_memory, check_sizes, nominal_work, relax, work_per_pass,
};
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, Square, SquareSampler, Tessellation,
};

/// The sites of capacity-constrained Voronoi tessellations of the square (Balzer, Schloemer and
/// Deussen 2009) with toroidal distances.
///
/// The square is represented by mass points, and each of the N sites owns exactly `capacity` of
/// them. The tessellation is a local minimum of the sum of the squared distances from the mass
/// points to their sites: each site is at the mean of its points, and no exchange of points between
/// two sites lowers the sum. The method is that of [`Ccvt`](crate::Ccvt) on the sphere.
///
/// Cells of equal mass with sites at their means have little power at low frequencies:
///
/// ```text
/// P(k) = 0.15 |k|^4/N^2            lattice of mass points, capacity 64, |k| << sqrt(N)
/// P(k) = 1/capacity as |k| -> 0    white mass points
/// ```
///
/// ```
/// use sphvar_samplers::{CcvtSquare, Purpose, SquareMassPoints, Streams};
/// let ccvt = CcvtSquare::new(100, 64, SquareMassPoints::Lattice)?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 100).realization(0);
/// let tessellation = ccvt.tessellate(&mut rng)?;
/// assert!(tessellation.is_settled());
/// // Regular hexagons have 0.1604, squares 0.1667.
/// assert!((tessellation.energy() - 0.174).abs() < 0.008);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CcvtSquare {
    n_points: usize,
    capacity: usize,
    mass_points: SquareMassPoints,
}

impl CcvtSquare {
    /// Maximum number of passes, after which a tessellation may be unsettled.
    pub const MAX_PASSES: usize = MAX_PASSES;

    /// Returns the pattern of tessellations with `n_points` sites of `capacity` mass points each.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if `n_points` or `capacity` is 0, or if their product is above
    /// `u32::MAX`.
    pub fn new(
        n_points: usize,
        capacity: usize,
        mass_points: SquareMassPoints,
    ) -> Result<Self, Error> {
        check_sizes(n_points, capacity)?;
        Ok(Self { n_points, capacity, mass_points })
    }

    /// Returns the number of mass points per site.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Returns the kind of mass points.
    #[must_use]
    pub fn mass_points(&self) -> SquareMassPoints {
        self.mass_points
    }

    /// Returns one tessellation, of which [`SquareSampler::sample_into`] keeps the sites.
    ///
    /// A single site is a uniform point, because the mass of the whole torus has no mean.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the mass points do not fit in memory.
    pub fn tessellate(&self, rng: &mut dyn Rng) -> Result<Tessellation<[f64; 2]>, Error> {
        Ok(self.relaxed(rng, &())?.tessellation(Into::into, Into::into))
    }

    fn relaxed(
        &self,
        rng: &mut dyn Rng,
        progress: &dyn Progress,
    ) -> Result<Relaxation<Torus, 2>, Error> {
        check_memory(self.n_points, self.capacity)?;
        let mut mass = PointSet::default();
        self.mass_points.draw_into(self.n_points * self.capacity, rng, &mut mass)?;
        let mass = mass.points.into_iter().map(Into::into).collect();
        let pass = work_per_pass(self.n_points, self.capacity);
        Ok(relax(Torus, mass, self.capacity, rng, &|| progress.tick(pass))?)
    }
}

impl SquareSampler for CcvtSquare {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn nominal_work(&self) -> f64 {
        nominal_work(self.n_points, self.capacity)
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
        points.extend(self.relaxed(rng, progress)?.sites().iter().map(|s| s.to_array()));
        Ok(())
    }
}

/// Parameters of the pattern [`CcvtSquare`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CcvtSquareParameters {
    /// Mass points per site.
    pub capacity: usize,
    /// The kind of mass points.
    pub mass: SquareMassPoints,
}

impl CcvtSquareParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { capacity: 64, mass: SquareMassPoints::Lattice };
}

impl Default for CcvtSquareParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for CcvtSquareParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        // Capacity times points is at most 2^32 - 1.
        let range = [1, i64::from(u32::MAX)];
        d.integer("capacity", range, "mass points of each site", &mut self.capacity);
        d.choice("mass", "what the mass points are", &mut self.mass);
    }
}

impl Definition<Square> for CcvtSquareParameters {
    fn facts(&self) -> PatternFacts {
        let (low_degrees, smooth, jump) = match self.mass {
            SquareMassPoints::White => ("1/capacity", -1.0, -1.0),
            SquareMassPoints::Lattice => ("0.15 |k|^4/N^2", -3.0, -1.5),
        };
        PatternFacts {
            cost: CostOrder::LINEAR.times("m log m, m = capacity"),
            low_degrees,
            smooth_rate: Rate::power(smooth),
            jump_rate: Rate::power(jump),
            is_extensible: false,
            source: "Balzer, Schloemer and Deussen 2009",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(CcvtSquare::new(n_points, self.capacity, self.mass)?))
    }
}
