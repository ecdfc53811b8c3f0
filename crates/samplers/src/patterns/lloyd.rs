use glam::DVec3;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use super::white_noise;
use crate::definition::Definition;
use crate::optimization::{remove_long_waves, voronoi};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler};

/// White noise without its low degrees, after some steps of Lloyd's relaxation (Lloyd 1982; on the
/// sphere Du, Gunzburger and Ju 2003): every step moves each point to the centroid of its Voronoi
/// cell.
///
/// Lloyd's steps level the density of points over distances of `sqrt(steps)` spacings; waves longer
/// than that remain. They are therefore removed first, up to degree sqrt(N)/2, by smooth
/// displacements along the gradient of the solution of Poisson's equation for the density. After 20
/// steps the power is about `l^2/(10 N)` to l = sqrt(N)/4, and 0.006 from there to sqrt(N)/2. With 0
/// steps the set is white noise.
///
/// Cells are exact rather than approximated by mass points. Because the centroid is the direction
/// of the integral of x over the cell, a step never increases [`quantization_energy`]. The
/// relaxation converges slowly, towards hexagons with a few defects; the number of steps is part of
/// the pattern. On the hemisphere the cells are those of the points and their antipodes together.
///
/// The distribution is invariant under rotations, so every single point is uniform. The cost of a
/// step is a planar Delaunay triangulation, O(N log N), of 2N points for the hemisphere; that of the
/// start five pairs of transforms to degree sqrt(N)/2.
///
/// ```
/// use sphvar_samplers::{Domain, Lloyd, Purpose, Sampler, Streams, quantization_energy};
/// let domain = Domain::Sphere;
/// let relaxed = |steps| -> Result<f64, sphvar_samplers::Error> {
///     let mut rng = Streams::new(0, Purpose::Pattern, 200).realization(0);
///     let set = Lloyd::new(200, domain, steps)?.sample(&mut rng)?;
///     Ok(quantization_energy(&set.points, domain))
/// };
/// assert!(relaxed(10)? < 0.6 * relaxed(0)?);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Lloyd {
    n_points: usize,
    domain: Domain,
    iterations: u32,
}

impl Lloyd {
    /// The default number of steps: the energy is within about 3 % of that of hexagons, for any N.
    pub const DEFAULT_ITERATIONS: u32 = 20;

    /// Returns the pattern of `n_points` points after `iterations` steps; 0 steps give white noise.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to 2^28.
    pub fn new(n_points: usize, domain: Domain, iterations: u32) -> Result<Self, Error> {
        if !(1..=voronoi::MAX_SITES / 2).contains(&n_points) {
            return Err(Error::Parameter {
                name: "the number of points to relax",
                range: "from 1 to 268435456",
                got: n_points as f64,
            });
        }
        Ok(Self { n_points, domain, iterations })
    }
}

impl Sampler for Lloyd {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn nominal_work(&self) -> f64 {
        160.0 * f64::from(self.iterations) / f64::from(Self::DEFAULT_ITERATIONS)
            * self.n_points as f64
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
        points.extend((0..self.n_points).map(|_| white_noise::uniform_direction(self.domain, rng)));
        if self.iterations > 0 {
            remove_long_waves(points, self.domain)?;
        }
        let mut sites = Vec::new();
        let mut moments = Vec::new();
        let step = self.nominal_work() / f64::from(self.iterations.max(1));
        for _ in 0..self.iterations {
            progress.tick(step)?;
            sites_of(points, self.domain, &mut sites);
            voronoi::cell_moments(&sites, &mut moments);
            for (p, moment) in points.iter_mut().zip(&moments) {
                // The point of a cell without a centroid, such as the whole sphere, stays in place.
                *p = self.domain.representative(moment.normalize_or(*p));
            }
        }
        Ok(())
    }
}

/// Parameters of the pattern [`Lloyd`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LloydParameters {
    /// Number of relaxation steps.
    pub iterations: u32,
}

impl LloydParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { iterations: Lloyd::DEFAULT_ITERATIONS };
}

impl Default for LloydParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for LloydParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "steps of the relaxation";
        d.integer("iterations", [0, i64::from(u32::MAX)], summary, &mut self.iterations);
    }
}

impl Definition for LloydParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC.times("per step"),
            low_degrees: "0.1 l^2/N",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Lloyd 1982; Du, Faber and Gunzburger 1999; low degrees: this project",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(Lloyd::new(n_points, domain, self.iterations)?))
    }
}

/// Returns the mean squared chord from a direction to the nearest point, times the area of the
/// domain: the energy that Lloyd's steps decrease.
///
/// ```text
/// E = int min_k |x - p_k|^2 d omega
/// ```
///
/// over the sphere, or over the hemisphere with the antipodal distance. For one point it is 8 pi
/// and 2 pi, respectively. For many points it is about `c area^2/N` with c = 1/pi for white noise
/// and the minimum, `5/(18 sqrt 3) = 0.1604`, for hexagons (Fejes Toth 1959). Points that coincide
/// to rounding may all count as having no cell. The cost is that of a triangulation.
#[must_use]
pub fn quantization_energy(points: &[DVec3], domain: Domain) -> f64 {
    let (mut sites, mut moments) = (Vec::new(), Vec::new());
    sites_of(points, domain, &mut sites);
    voronoi::cell_moments(&sites, &mut moments);
    // |x - p|^2 = 2 - 2 x.p, integrated over the cell of each point.
    let inner: f64 = points.iter().zip(&moments).map(|(p, moment)| p.dot(*moment)).sum();
    2.0 * domain.area() - 2.0 * inner
}

/// Replaces the content of `sites` by `points`, on the hemisphere with their antipodes.
fn sites_of(points: &[DVec3], domain: Domain, sites: &mut Vec<DVec3>) {
    sites.clear();
    sites.extend_from_slice(points);
    if domain == Domain::Hemisphere {
        sites.extend(points.iter().map(|&p| -p));
    }
}
