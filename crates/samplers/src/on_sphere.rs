use std::f64::consts::TAU;

use glam::DVec3;
use rand::Rng;

use crate::{Domain, Error, Sampler, SquarePattern, archimedes};

/// A pattern of the square, carried to the sphere or the hemisphere by the area-preserving map of
/// Archimedes.
///
/// ```text
/// z = 1 - 2u (sphere), z = 1 - u (hemisphere),   phi = 2 pi v
/// ```
///
/// The map keeps areas, not shapes: near the poles cells of the square become slivers, and on the
/// hemisphere the edge u = 1 becomes the equator, where a direction meets antipodes that the
/// pattern knows nothing of.
///
/// ```
/// use sphvar_samplers::{Domain, Hammersley, OnSphere, Purpose, Sampler, Streams};
/// let sampler = OnSphere::new(Hammersley::new(100)?, Domain::Hemisphere);
/// let points = sampler.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// assert!(points.len() == 100 && points.iter().all(|p| p.z >= 0.0));
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct OnSphere<P> {
    pattern: P,
    domain: Domain,
}

impl<P: SquarePattern> OnSphere<P> {
    /// The pattern `pattern` on `domain`.
    #[must_use]
    pub fn new(pattern: P, domain: Domain) -> Self {
        Self { pattern, domain }
    }
}

impl<P: SquarePattern> Sampler for OnSphere<P> {
    fn n_points(&self) -> usize {
        self.pattern.n_points()
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn is_random(&self) -> bool {
        self.pattern.is_random()
    }

    fn sample_into(&self, rng: &mut dyn Rng, points: &mut Vec<DVec3>) -> Result<(), Error> {
        let height = match self.domain {
            Domain::Sphere => 2.0,
            Domain::Hemisphere => 1.0,
        };
        let square = self.pattern.fill(rng)?;
        points.clear();
        points.extend(square.iter().map(|[u, v]| archimedes::direction(height * u, TAU * v)));
        Ok(())
    }
}
