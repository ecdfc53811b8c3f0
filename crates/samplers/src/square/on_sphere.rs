use std::f64::consts::TAU;

use rand::Rng;

use sphvar_warps::archimedes;

use crate::{Domain, Error, PointSet, Sampler, SetDistribution, SquareSampler};

/// A pattern of the square mapped to the sphere or the hemisphere by the area-preserving map of
/// Archimedes.
///
/// ```text
/// z = 1 - 2u (sphere), z = 1 - u (hemisphere),   phi = 2 pi v
/// ```
///
/// The map preserves areas, not shapes: near the poles cells of the square become slivers. On the
/// hemisphere the edge u = 1 becomes the equator, where the pattern does not account for antipodes.
///
/// ```
/// use sphvar_samplers::{Domain, Hammersley, OnSphere, Purpose, Sampler, Streams};
/// let sampler = OnSphere::new(Hammersley::new(100)?, Domain::Hemisphere);
/// let set = sampler.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// assert!(set.len() == 100 && set.points.iter().all(|p| p.z >= 0.0));
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct OnSphere<P> {
    pattern: P,
    domain: Domain,
}

impl<P: SquareSampler> OnSphere<P> {
    /// Returns `pattern` on `domain`.
    #[must_use]
    pub fn new(pattern: P, domain: Domain) -> Self {
        Self { pattern, domain }
    }
}

impl<P: SquareSampler> Sampler for OnSphere<P> {
    fn n_points(&self) -> usize {
        self.pattern.n_points()
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        if self.pattern.is_random() { SetDistribution::Random } else { SetDistribution::Fixed }
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let height = match self.domain {
            Domain::Sphere => 2.0,
            Domain::Hemisphere => 1.0,
        };
        let square = self.pattern.sample(rng)?;
        set.start().extend(square.points.iter().map(|[u, v]| archimedes(height * u, TAU * v)));
        set.weights.extend(square.weights);
        Ok(())
    }
}
