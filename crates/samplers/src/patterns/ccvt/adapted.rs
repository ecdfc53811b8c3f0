use std::sync::Arc;

use glam::DVec3;
use rand::Rng;
use sphvar_warps::{Measure, Warp};

use super::Directions;
use crate::tessellation::{check_memory, check_sizes, nominal_work, settle, work_per_pass};
use crate::{Error, PointSet, Progress, R2, Shifted, SquareSampler, Tessellation};

/// Capacity-constrained Voronoi tessellations for a density on the sphere: cells of equal mass.
///
/// The mass points are those of a randomly shifted sequence [`R2`] mapped by the density's
/// [`Warp`], so that each represents the same mass with little noise. As in [`Ccvt`](crate::Ccvt),
/// each of the N sites owns `capacity` of them and is at their intrinsic (Karcher) mean, and no
/// exchange of points between two sites lowers the sum of the squared geodesic distances.
///
/// The distribution is not invariant under rotations, and its sites are no image of a pattern of the
/// square under the warp: no spectrum predicts the variance of integrals.
///
/// # Performance
///
/// As [`Ccvt`](crate::Ccvt), and the time of the warp for each mass point.
///
/// # Examples
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use sphvar_samplers::{AdaptedCcvt, Purpose, Streams};
/// use sphvar_warps::VonMisesFisherLobe;
///
/// let ccvt = AdaptedCcvt::new(16, 64, Arc::new(VonMisesFisherLobe::new(50.0)?))?;
/// let mut rng = Streams::new(0, Purpose::Pattern, 16).realization(0);
/// let tessellation = ccvt.tessellate(&mut rng, &())?;
/// let mean: DVec3 = tessellation.sites().iter().sum::<DVec3>() / 16.0;
/// assert!((mean.z - (1.0 - 1.0 / 50.0)).abs() < 0.005);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # References
///
/// Balzer, Schloemer and Deussen 2009, section 3, for densities in the plane.
#[derive(Clone, Debug)]
pub struct AdaptedCcvt {
    n_points: usize,
    capacity: usize,
    density: Arc<dyn Warp>,
}

impl AdaptedCcvt {
    /// Returns tessellations with `n_points` sites of `capacity` mass points each.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if `n_points` or `capacity` is 0 or their product is above `u32::MAX`,
    /// [`Error::Given`] if the density is not one of directions.
    pub fn new(n_points: usize, capacity: usize, density: Arc<dyn Warp>) -> Result<Self, Error> {
        check_sizes(n_points, capacity)?;
        if density.measure() != Measure::SolidAngle {
            let reason = "the density of a CCVT must be one of directions, got one on the disk";
            return Err(Error::Given { reason: reason.to_owned() });
        }
        Ok(Self { n_points, capacity, density })
    }

    /// Returns the number of sites.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the number of mass points per site.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Returns the nominal work of a tessellation.
    #[must_use]
    pub fn nominal_work(&self) -> f64 {
        nominal_work(self.n_points, self.capacity)
    }

    /// Returns one tessellation.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the mass points do not fit in memory, and the error of a
    /// `progress` that stops the work.
    pub fn tessellate(
        &self,
        rng: &mut dyn Rng,
        progress: &dyn Progress,
    ) -> Result<Tessellation, Error> {
        check_memory(self.n_points, self.capacity)?;
        let mut square = PointSet::default();
        Shifted::new(R2::new(self.n_points * self.capacity)?).sample_into(rng, &mut square)?;
        let mass: Vec<DVec3> = square.points.iter().map(|&u| self.density.map(u)).collect();
        drop(square);
        let pass = work_per_pass(self.n_points, self.capacity);
        let space = Directions { antipodal: false };
        let settled = settle(space, mass, self.capacity, rng, &|| progress.tick(pass))?;
        Ok(settled.tessellation(|p| p, |s| s))
    }
}
