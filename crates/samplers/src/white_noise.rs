use std::f64::consts::TAU;

use glam::DVec3;
use rand::{Rng, RngExt};

use crate::{Domain, Error, Sampler, archimedes};

/// Independent, uniformly distributed directions: `P(l) = 1` for every l >= 1, variance
/// `(area int F^2 - (int F)^2)/N`.
#[derive(Clone, Copy, Debug)]
pub struct WhiteNoise {
    n_points: usize,
    domain: Domain,
}

impl WhiteNoise {
    pub(crate) fn new(n_points: usize, domain: Domain) -> Self {
        Self { n_points, domain }
    }
}

impl Sampler for WhiteNoise {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn is_random(&self) -> bool {
        true
    }

    fn sample_into(&self, rng: &mut dyn Rng, points: &mut Vec<DVec3>) -> Result<(), Error> {
        points.clear();
        points.extend((0..self.n_points).map(|_| uniform_direction(self.domain, rng)));
        Ok(())
    }
}

/// A uniformly distributed direction of `domain`.
pub(crate) fn uniform_direction(domain: Domain, rng: &mut dyn Rng) -> DVec3 {
    let height = match domain {
        Domain::Sphere => 2.0,
        Domain::Hemisphere => 1.0,
    };
    let drop = height * rng.random::<f64>();
    archimedes::direction(drop, TAU * rng.random::<f64>())
}
