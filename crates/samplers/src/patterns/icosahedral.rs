use glam::DVec3;
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::rule::{Rule, checked_size, is_kept};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The golden ratio.
const PHI: f64 = 1.618033988749894848;

/// The vertices of a geodesic icosahedron of frequency f: each face of the icosahedron is divided into
/// f^2 congruent triangles, whose 10 f^2 + 2 vertices are projected from the centre onto the sphere
/// (class I, method 1 of Clinton 1971), with equal weights.
///
/// The symmetry of the icosahedron makes degrees 1 to 5 exact. Beyond them equal weights leave a
/// bias, because central projection makes the points twice as dense near the vertices of the
/// icosahedron as at the centres of its faces.
/// The set is antipodally symmetric; the hemisphere has one of each pair, 5 f^2 + 1 points.
#[derive(Clone, Copy, Debug)]
pub struct GeodesicRule {
    frequency: u32,
    domain: Domain,
}

/// A point with coordinates `a + b phi`, multiplied by the frequency: integers, so that symmetric
/// points are so exactly.
#[derive(Clone, Copy, Debug)]
struct Lattice([[i32; 2]; 3]);

impl Lattice {
    /// Returns the 12 vertices of the icosahedron: (0, +-1, +-phi) and its cyclic permutations.
    fn vertices() -> impl Iterator<Item = Self> {
        (0..3).flat_map(|axis| {
            [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(|[one, phi]| {
                let mut vertex = [[0, 0], [one, 0], [0, phi]];
                vertex.rotate_right(axis);
                Self(vertex)
            })
        })
    }

    fn position(self) -> DVec3 {
        DVec3::from_array(self.0.map(|[a, b]| f64::from(a) + f64::from(b) * PHI))
    }

    /// Returns whether two vertices of the icosahedron share an edge, which has length 2.
    fn is_adjacent(self, other: Self) -> bool {
        (self.position().distance_squared(other.position()) - 4.0).abs() < 1.0
    }

    /// Returns the sum of points with integer factors.
    fn combine<const K: usize>(terms: [(u32, Self); K]) -> DVec3 {
        let sum = |i: usize| {
            let part = |j: usize| -> f64 {
                terms.iter().map(|(factor, p)| f64::from(*factor) * f64::from(p.0[i][j])).sum()
            };
            part(0) + part(1) * PHI
        };
        DVec3::new(sum(0), sum(1), sum(2)).normalize()
    }
}

impl GeodesicRule {
    /// Returns the rule of a frequency.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `frequency` is from 1 to 32768.
    pub fn new(frequency: u32, domain: Domain) -> Result<Self, Error> {
        Ok(Self { frequency: checked_size("the frequency of icosahedral", frequency)?, domain })
    }
}

impl Rule for GeodesicRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        let frequency = self.frequency as usize;
        match self.domain {
            Domain::Sphere => 10 * frequency * frequency + 2,
            Domain::Hemisphere => 5 * frequency * frequency + 1,
        }
    }

    fn exact_degree(&self) -> usize {
        5
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let f = self.frequency;
        let vertices: Vec<Lattice> = Lattice::vertices().collect();
        let mut add = |p: DVec3| set.points.extend(Some(p).filter(|&p| is_kept(self.domain, p)));
        for (i, &u) in vertices.iter().enumerate() {
            add(Lattice::combine([(1, u)]));
            let later = vertices[i + 1..].iter().enumerate();
            for (j, &v) in later.filter(|(_, v)| u.is_adjacent(**v)) {
                (1..f).for_each(|b| add(Lattice::combine([(f - b, u), (b, v)])));
                let last = vertices[i + j + 2..].iter();
                for &w in last.filter(|w| u.is_adjacent(**w) && v.is_adjacent(**w)) {
                    for b in 1..f {
                        (1..f - b)
                            .for_each(|c| add(Lattice::combine([(f - b - c, u), (b, v), (c, w)])));
                    }
                }
            }
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
            low_degrees: "0 for l < 6, grows as N at 6",
            smooth_rate: Rate::Biased,
            jump_rate: Rate::Biased,
            is_extensible: false,
            source: "Clinton 1971",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        let (square, constant) = match domain {
            Domain::Sphere => (10, 2),
            Domain::Hemisphere => (5, 1),
        };
        ValidCounts::Quadratic { square, linear: 0, constant, root: "f" }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let frequency = self.valid_counts(domain).size("icosahedral", n_points)?;
        Ok(Box::new(GeodesicRule::new(frequency, domain)?))
    }
}
