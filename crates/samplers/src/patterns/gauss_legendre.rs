use std::f64::consts::PI;

use sphvar_grammar::Parametric;
use sphvar_sh::GaussLegendre;

use crate::definition::Definition;
use crate::rule::{Ring, Rule, checked_size};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The Gauss-Legendre product rule: L rings at the nodes of Gauss-Legendre quadrature in
/// z = cos(theta), each of 2L equally spaced nodes of weight `pi w_k/L`; 2 L^2 nodes, exact to
/// degree 2L - 1 (Atkinson 1982, section 3).
///
/// The set is antipodally symmetric; the hemisphere has one of each pair, L^2 nodes.
#[derive(Clone, Copy, Debug)]
pub struct GaussLegendreRule {
    n_rings: u32,
    domain: Domain,
}

impl GaussLegendreRule {
    /// Returns the rule with `n_rings` rings on the sphere.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_rings` is from 1 to 32768.
    pub fn new(n_rings: u32, domain: Domain) -> Result<Self, Error> {
        Ok(Self {
            n_rings: checked_size("the number of rings of gauss-legendre", n_rings)?,
            domain,
        })
    }
}

impl Rule for GaussLegendreRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        let n_rings = self.n_rings as usize;
        match self.domain {
            Domain::Sphere => 2 * n_rings * n_rings,
            Domain::Hemisphere => n_rings * n_rings,
        }
    }

    fn exact_degree(&self) -> usize {
        2 * self.n_rings as usize - 1
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let n = self.n_rings as usize;
        let rule = GaussLegendre::new(n)
            .map_err(|error| Error::Degree { last: 2 * n - 1, reason: error.to_string() })?;
        // From the north down.
        for (k, (z, weight)) in rule.nodes().iter().zip(rule.weights()).enumerate().rev() {
            let is_equator = 2 * k + 1 == n;
            let cos = if is_equator { 0.0 } else { *z };
            let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
            let ring = Ring { sin, cos, n_nodes: 2 * self.n_rings, weight: PI * weight / n as f64 };
            ring.append_half(self.domain, set);
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
            source: "Atkinson 1982",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        let unit = match domain {
            Domain::Sphere => 2,
            Domain::Hemisphere => 1,
        };
        ValidCounts::Squares { unit, root: "L" }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let n_rings = self.valid_counts(domain).size("gauss-legendre", n_points)?;
        Ok(Box::new(GaussLegendreRule::new(n_rings, domain)?))
    }
}
