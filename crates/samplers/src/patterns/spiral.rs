use std::f64::consts::TAU;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::Parametric;
use sphvar_warps::archimedes;

use crate::definition::Definition;
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution, count,
};

/// The advance along the spiral per point, in units of `1/sqrt(N)` of arc: the value that
/// Rakhmanov, Saff and Zhou give from numerical experiments.
const STEP: f64 = 3.6;

/// The generalized spiral points (Rakhmanov, Saff and Zhou 1994, section 4), from the south pole
/// to the north pole.
///
/// ```text
/// h_k = -1 + 2(k-1)/(N-1),   k = 1..N
/// phi_k = phi_(k-1) + 3.6 / sqrt(N (1 - h_k^2))  (mod 2 pi),   phi_1 = phi_N = 0
/// ```
///
/// A single point is the south pole. On the hemisphere half of that set would not be a pattern of N
/// points, and the point at the pole of every set would be an artifact. There the pattern uses the
/// step of a spiral of 2N points on midpoint heights, from the equator up:
///
/// ```text
/// h_k = (2k-1)/(2N),   phi_k = phi_(k-1) + 3.6 / sqrt(2N (1 - h_k^2)),   phi_1 = 0.
/// ```
///
/// The pattern is deterministic: all realizations are the same set. The longitude is a running sum
/// whose rounding error is at most N `EPSILON` radians.
#[derive(Clone, Copy, Debug)]
pub struct GeneralizedSpiral {
    n: u32,
    domain: Domain,
}

impl GeneralizedSpiral {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize, domain: Domain) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, domain })
    }

    /// Returns the distance 1 - |h| of point `k` (from 0) from the nearer pole, and whether that is
    /// the north pole. It is computed from integers, which avoids cancellation near either pole.
    fn height(self, k: u32) -> (f64, bool) {
        let (k, n) = (f64::from(k), f64::from(self.n));
        match self.domain {
            Domain::Hemisphere => ((2.0 * (n - k) - 1.0) / (2.0 * n), true),
            Domain::Sphere if self.n == 1 => (0.0, false),
            Domain::Sphere if 2.0 * k < n - 1.0 => (2.0 * k / (n - 1.0), false),
            Domain::Sphere => (2.0 * (n - 1.0 - k) / (n - 1.0), true),
        }
    }
}

impl Sampler for GeneralizedSpiral {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        let per_sphere = match self.domain {
            Domain::Sphere => f64::from(self.n),
            Domain::Hemisphere => 2.0 * f64::from(self.n),
        };
        let mut phi = 0.0;
        points.extend((0..self.n).map(|k| {
            let (drop, north) = self.height(k);
            if drop <= 0.0 {
                phi = 0.0;
            } else if k > 0 {
                phi = (phi + STEP / (per_sphere * drop * (2.0 - drop)).sqrt()) % TAU;
            }
            let p = archimedes(drop, phi);
            if north { p } else { DVec3::new(p.x, p.y, -p.z) }
        }));
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Rakhmanov, Saff and Zhou 1994",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(GeneralizedSpiral::new(n_points, domain)?))
    }
}
