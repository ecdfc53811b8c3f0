use std::f64::consts::FRAC_PI_4;

use glam::DVec3;
use sphvar_grammar::{Choice, Declaration, Parametric};

use crate::definition::Definition;
use crate::rule::{Rule, checked_size, is_kept};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The spacing of the lines of a cube-sphere grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CubeSpacing {
    /// Equal angles at the centre of the sphere (Ronchi, Iacono and Paolucci 1996).
    #[default]
    Equiangular,
    /// Equal distances on the faces of the cube (Sadourny 1972).
    Equidistant,
}

impl Choice for CubeSpacing {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("equiangular", Self::Equiangular), ("equidistant", Self::Equidistant)];
}

/// The centres of the cells of a cube-sphere grid: k x k cells on each face of the cube, projected
/// from the centre onto the sphere; 6 k^2 points of equal weight.
///
/// The symmetry of the cube makes degrees 1 to 3 exact. Beyond them equal weights leave a bias, because
/// cells differ in area. The set is antipodally symmetric; the hemisphere has one of each pair, 3 k^2
/// points.
#[derive(Clone, Copy, Debug)]
pub struct CubeRule {
    size: u32,
    domain: Domain,
    spacing: CubeSpacing,
}

impl CubeRule {
    /// Returns the rule of `size` x `size` cells on each face.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `size` is from 1 to 32768.
    pub fn new(size: u32, spacing: CubeSpacing, domain: Domain) -> Result<Self, Error> {
        Ok(Self {
            size: checked_size("the number of cells along an edge of cube-sphere", size)?,
            spacing,
            domain,
        })
    }
}

impl Rule for CubeRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        let size = self.size as usize;
        match self.domain {
            Domain::Sphere => 6 * size * size,
            Domain::Hemisphere => 3 * size * size,
        }
    }

    fn exact_degree(&self) -> usize {
        3
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let size = f64::from(self.size);
        let line = |i: u32| {
            // From -1 to 1; odd in its index, so that antipodes are exact.
            let x = (f64::from(2 * i + 1) - size) / size;
            match self.spacing {
                CubeSpacing::Equiangular => (FRAC_PI_4 * x).tan(),
                CubeSpacing::Equidistant => x,
            }
        };
        let lines: Vec<f64> = (0..self.size).map(line).collect();
        for axis in 0..3 {
            for side in [1.0, -1.0] {
                for &u in &lines {
                    set.points.extend(
                        lines
                            .iter()
                            .map(|&v| {
                                let mut p = [side, u, v];
                                p.rotate_right(axis);
                                DVec3::from_array(p).normalize()
                            })
                            .filter(|&p| is_kept(self.domain, p)),
                    );
                }
            }
        }
        Ok(())
    }
}

/// Parameters of the pattern `cube-sphere`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeSphereParameters {
    /// The spacing of the lines of the grid.
    pub spacing: CubeSpacing,
}

impl CubeSphereParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { spacing: CubeSpacing::Equiangular };
}

impl Default for CubeSphereParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for CubeSphereParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice("spacing", "of the lines, by angle or on the cube", &mut self.spacing);
    }
}

impl Definition for CubeSphereParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "0 for l < 4, grows as N at 4",
            smooth_rate: Rate::Biased,
            jump_rate: Rate::Biased,
            is_extensible: false,
            source: match self.spacing {
                CubeSpacing::Equiangular => "Ronchi, Iacono and Paolucci 1996",
                CubeSpacing::Equidistant => "Sadourny 1972",
            },
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        let unit = match domain {
            Domain::Sphere => 6,
            Domain::Hemisphere => 3,
        };
        ValidCounts::Squares { unit, root: "k" }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let size = self.valid_counts(domain).size("cube-sphere", n_points)?;
        Ok(Box::new(CubeRule::new(size, self.spacing, domain)?))
    }
}
