use std::f64::consts::PI;

use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::rule::{Ring, Rule, Sines, checked_size};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The equiangular rule of Driscoll and Healy 1994 (theorem 3): 2L rings at colatitudes
/// `pi j/(2L)`, j = 0..2L-1, each of 2L equally spaced nodes of weight
///
/// ```text
/// (4 pi/L^2) sin(theta_j)/2 sum_{k=0}^{L-1} sin((2k+1) theta_j)/(2k+1).
/// ```
///
/// It is exact to degree 2L - 1. The ring at the north pole is one node, so that there are
/// 4 L^2 - 2L + 1. Its weight is 0: it belongs to the grid that a transform needs, but integrals do
/// not use it, and the other nodes are antipodally symmetric. The hemisphere has one of each of their
/// pairs and the pole, 2 L^2 - L + 1 nodes.
#[derive(Clone, Copy, Debug)]
pub struct DriscollHealyRule {
    size: u32,
    domain: Domain,
}

impl DriscollHealyRule {
    /// Returns the rule with `2 size` rings on the sphere.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `size` is from 1 to 32768.
    pub fn new(size: u32, domain: Domain) -> Result<Self, Error> {
        Ok(Self { size: checked_size("the size L of driscoll-healy", size)?, domain })
    }
}

impl Rule for DriscollHealyRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        let size = self.size as usize;
        match self.domain {
            Domain::Sphere => 4 * size * size - 2 * size + 1,
            Domain::Hemisphere => 2 * size * size - size + 1,
        }
    }

    fn exact_degree(&self) -> usize {
        2 * self.size as usize - 1
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let size = self.size as usize;
        let sines = Sines::new(2 * size);
        Ring { sin: 0.0, cos: 1.0, n_nodes: 1, weight: 0.0 }.append(self.domain, set);
        for j in 1..2 * size {
            let sum: f64 = (1..2 * size).step_by(2).map(|k| sines.sin(k * j) / k as f64).sum();
            let sin = sines.sin(j);
            let weight = 2.0 * PI * sin * sum / (size * size) as f64;
            // The cosine of the equator is exactly 0.
            let cos = if j == size { 0.0 } else { sines.cos(j) };
            Ring { sin, cos, n_nodes: 2 * self.size, weight }.append_half(self.domain, set);
        }
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
            low_degrees: "0 for l < 2L",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Driscoll and Healy 1994",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        let (square, linear) = match domain {
            Domain::Sphere => (4, 2),
            Domain::Hemisphere => (2, 1),
        };
        ValidCounts::Quadratic { square, linear, constant: 1, root: "L" }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let size = self.valid_counts(domain).size("driscoll-healy", n_points)?;
        Ok(Box::new(DriscollHealyRule::new(size, domain)?))
    }
}
