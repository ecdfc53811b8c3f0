use std::f64::consts::PI;

use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::rule::{Ring, Rule, Sines, checked_size};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The equiangular rule of McEwen and Wiaux 2011 (section IV): L rings at colatitudes
/// `pi (2t+1)/(2L-1)`, t = 0..L-1, each of 2L - 1 equally spaced nodes, the last one the south pole.
///
/// Functions of colatitude are extended to the whole circle, where their integrals follow from their
/// Fourier coefficients; the ring at `theta_t` and its reflection at `2 pi - theta_t` together have the
/// weight
///
/// ```text
/// q_t = 4/(2L-1) sum_{|m| < L, m even} cos(m theta_t)/(1 - m^2),
/// ```
///
/// and the pole half of that. The rule is exact to degree L - 1. With the pole as one node, it has
/// 2 L^2 - 3L + 2 nodes. They are not antipodally symmetric, so the hemisphere has as many: those
/// below the equator are replaced by their antipodes.
#[derive(Clone, Copy, Debug)]
pub struct McEwenWiauxRule {
    size: u32,
    domain: Domain,
}

impl McEwenWiauxRule {
    /// Returns the rule with `size` rings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `size` is from 1 to 32768.
    pub fn new(size: u32, domain: Domain) -> Result<Self, Error> {
        Ok(Self { size: checked_size("the size L of mcewen-wiaux", size)?, domain })
    }
}

impl Rule for McEwenWiauxRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        let size = self.size as usize;
        2 * size * size + 2 - 3 * size
    }

    fn exact_degree(&self) -> usize {
        self.size as usize - 1
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let (size, n_nodes) = (self.size as usize, 2 * self.size - 1);
        let n = n_nodes as usize;
        // Multiples of pi/(4L - 2), so that the right angle is one.
        let sines = Sines::new(2 * n);
        // The share of the domain in the area 4 pi.
        let share = self.domain.area() / (4.0 * PI);
        for t in 0..size {
            let angle = 2 * (2 * t + 1);
            let terms = (2..size).step_by(2);
            let cosines = terms.map(|m| 2.0 * sines.cos(m * angle) / (1.0 - (m * m) as f64));
            let q = 4.0 / n as f64 * (1.0 + cosines.sum::<f64>());
            let weight = share * 2.0 * PI * q;
            let ring = if t + 1 == size {
                Ring { sin: 0.0, cos: -1.0, n_nodes: 1, weight: 0.5 * weight }
            } else {
                let weight = weight / n as f64;
                Ring { sin: sines.sin(angle), cos: sines.cos(angle), n_nodes, weight }
            };
            ring.append(self.domain, set);
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
            low_degrees: "0 for l < L",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "McEwen and Wiaux 2011",
        }
    }

    fn valid_counts(&self, _: Domain) -> ValidCounts {
        ValidCounts::Quadratic { square: 2, linear: 3, constant: 2, root: "L" }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let size = self.valid_counts(domain).size("mcewen-wiaux", n_points)?;
        Ok(Box::new(McEwenWiauxRule::new(size, domain)?))
    }
}
