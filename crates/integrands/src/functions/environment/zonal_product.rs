//! Products of a map and a function of z.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_sh::{ByParity, CompensatedSum, Domain};

use super::EnvironmentMap;
use super::nodes::Node;
use crate::shape::coaxial;
use crate::{Circle, Coefficients, Error, Integrand, Shape};

/// The product of a map and a function of z alone, such as the cosine that weights incident light.
///
/// Integrals over phi are those of the map in closed form, so results follow from the rows of the
/// map, like those of the map itself, instead of values between all its edges.
pub(crate) struct ZonalProduct<'a> {
    map: &'a EnvironmentMap,
    factor: &'a dyn Integrand,
    /// The shape of the factor.
    shape: Shape,
    /// The colatitudes of its edges and of the ends of its support.
    edges: Vec<f64>,
    /// The colatitudes of its support.
    limits: [f64; 2],
}

impl<'a> ZonalProduct<'a> {
    /// Returns the product of two functions if one is a map and the other a function of z that is
    /// smooth between its edges.
    pub(crate) fn of(first: &'a dyn Integrand, second: &'a dyn Integrand) -> Option<Self> {
        let (map, factor) = match (first.environment_map(), second.environment_map()) {
            (Some(map), None) => (map, second),
            (None, Some(map)) => (map, first),
            _ => return None,
        };
        let shape = factor.shape().ok()?;
        let has_pole = |axis: DVec3| coaxial(axis, DVec3::Z).is_some();
        if shape.is_fractional() || !shape.axis().is_some_and(has_pole) {
            return None;
        }
        let mut limits = [0.0, PI];
        let mut edges = Vec::new();
        for edge in shape.edges() {
            let is_upper = coaxial(edge.axis, DVec3::Z)? > 0.0;
            edges.push(if is_upper { edge.angle } else { PI - edge.angle });
        }
        if let Some(Circle { axis, angle }) = shape.support() {
            limits = if coaxial(axis, DVec3::Z)? > 0.0 { [0.0, angle] } else { [PI - angle, PI] };
            edges.extend(limits);
        }
        edges.sort_by(f64::total_cmp);
        Some(Self { map, factor, shape, edges, limits })
    }

    /// Returns `int f` over the domain.
    pub(crate) fn integral(&self, domain: Domain) -> Result<f64, Error> {
        let nodes = self.nodes(domain, 2)?;
        Ok(self.sum(&nodes, |row| row.iter().sum()))
    }

    /// Returns the coefficients to degree `lmax`.
    pub(crate) fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        if lmax == 0 {
            let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
            let mean = copies * self.integral(domain)? / (4.0 * PI).sqrt();
            return Coefficients::zonal(DVec3::Z, vec![mean]);
        }
        let nodes: Vec<Node> = self
            .nodes(domain, lmax)?
            .into_iter()
            .map(|(node, factor)| Node { weight: node.weight * factor, ..node })
            .collect();
        let part = Coefficients::general(self.map.alm_of_nodes(&nodes, lmax)?);
        Ok(if domain == Domain::Sphere { part } else { part.even_extension() })
    }

    /// Returns the centred squares of both parities; `None` on the sphere if the function and its
    /// mirror image overlap.
    pub(crate) fn centred_square(&self, domain: Domain) -> Result<Option<ByParity>, Error> {
        if domain == Domain::Hemisphere {
            let even = 2.0 * self.variation(domain, domain.area())?.0;
            return Ok(Some(ByParity { even, odd: 0.0 }));
        }
        if !self.shape.is_apart_from(&self.shape.mirrored()) {
            return Ok(None);
        }
        // Both parts have half the values here and half the values, up to the sign, at the
        // antipodes, where the function is 0.
        let (variation, square) = self.variation(domain, TAU)?;
        Ok(Some(ByParity { even: 0.5 * variation, odd: 0.5 * square }))
    }

    /// Returns `int (f - mean)^2` over a region of the given area that contains the support, and
    /// `int f^2`.
    fn variation(&self, domain: Domain, area: f64) -> Result<(f64, f64), Error> {
        /// The relative rounding error of the area of the nodes.
        const ROUNDING: f64 = 1e-13;
        let nodes = self.nodes(domain, 2)?;
        let mean = self.sum(&nodes, |row| row.iter().sum()) / area;
        // A row is linear between texels: the integral of its square is that of Simpson's rule.
        let square = |row: &[f64], offset: f64| -> f64 {
            let next = row.iter().cycle().skip(1);
            let pairs = row.iter().zip(next).map(|(a, b)| (a - offset, b - offset));
            pairs.map(|(a, b)| (a * a + a * b + b * b) / 3.0).sum()
        };
        let covered = self.sum(&nodes, |row| row.len() as f64);
        let beyond = 1.0 - covered / area;
        let beyond = if beyond.abs() > ROUNDING { beyond * area * mean * mean } else { 0.0 };
        let of_square = self.sum(&nodes, |row| square(row, 0.0));
        Ok((self.sum(&nodes, |row| square(row, mean)) + beyond, of_square))
    }

    /// Returns the integral over theta of a sum over the texels of a row of the product, and over
    /// phi.
    fn sum(&self, nodes: &[(Node, f64)], of_row: impl Fn(&[f64]) -> f64) -> f64 {
        let mut sum = CompensatedSum::default();
        let mut row = vec![0.0; self.map.width];
        for (Node { rows, share, weight, .. }, factor) in nodes {
            let (above, below) = (self.map.row(rows.0), self.map.row(rows.1));
            for (value, (a, b)) in row.iter_mut().zip(above.iter().zip(below)) {
                *value = factor * (a + share * (b - a));
            }
            sum.add(weight * of_row(&row));
        }
        TAU / self.map.width as f64 * sum.value()
    }

    /// Returns nodes over theta with the values of the factor there, for products with functions of a
    /// degree, in the support.
    fn nodes(&self, domain: Domain, degree: usize) -> Result<Vec<(Node, f64)>, Error> {
        // The square of the factor has twice its degree.
        let degree = degree + 2 * self.shape.degree();
        let mut nodes = self.map.nodes_between(&self.edges, domain, degree)?;
        let theta = |node: &Node| node.colatitude.sin().atan2(node.colatitude.cos());
        let [from, to] = self.limits;
        nodes.retain(|node| (from..=to).contains(&theta(node)));
        let direction = |node: &Node| DVec3::new(node.colatitude.sin(), 0.0, node.colatitude.cos());
        let dirs: Vec<DVec3> = nodes.iter().map(direction).collect();
        let mut values = vec![0.0; dirs.len()];
        self.factor.eval_into(&dirs, &mut values)?;
        Ok(nodes.into_iter().zip(values).collect())
    }
}
