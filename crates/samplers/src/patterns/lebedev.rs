use std::borrow::Cow;

use glam::DVec3;
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::rule::{Rule, is_kept};
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, ValidCounts};

/// The orbits of all rules, made by `benches/lebedev_rules.py` from `scipy.integrate.lebedev_rule`:
/// lines `degree,a,b,c,w` with the coordinates of one node, `a >= b >= c >= 0`, and its weight.
const ORBITS: &str = include_str!("../../data/lebedev.csv");

/// The number of nodes and the degree of each rule.
const RULES: [(usize, usize); 32] = [
    (6, 3),
    (14, 5),
    (26, 7),
    (38, 9),
    (50, 11),
    (74, 13),
    (86, 15),
    (110, 17),
    (146, 19),
    (170, 21),
    (194, 23),
    (230, 25),
    (266, 27),
    (302, 29),
    (350, 31),
    (434, 35),
    (590, 41),
    (770, 47),
    (974, 53),
    (1202, 59),
    (1454, 65),
    (1730, 71),
    (2030, 77),
    (2354, 83),
    (2702, 89),
    (3074, 95),
    (3470, 101),
    (3890, 107),
    (4334, 113),
    (4802, 119),
    (5294, 125),
    (5810, 131),
];

const COUNTS: [usize; RULES.len()] = counts(1);
const HALF_COUNTS: [usize; RULES.len()] = counts(2);

const fn counts(divisor: usize) -> [usize; RULES.len()] {
    let mut counts = [0; RULES.len()];
    let mut k = 0;
    while k < RULES.len() {
        counts[k] = RULES[k].0 / divisor;
        k += 1;
    }
    counts
}

/// The rule of Lebedev of a degree from 3 to 131, invariant under the octahedral group (Lebedev and
/// Laikov 1999).
///
/// The rules of degrees 13, 25 and 27 have negative weights. All are antipodally symmetric; the
/// hemisphere has one of each pair of nodes.
#[derive(Clone, Copy, Debug)]
pub struct LebedevRule {
    n_nodes: usize,
    degree: usize,
    domain: Domain,
}

impl LebedevRule {
    /// Returns the rule of a degree: the odd ones from 3 to 31, and every sixth from 35 to 131.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if there is no rule of this degree.
    pub fn new(degree: usize, domain: Domain) -> Result<Self, Error> {
        let rule = RULES.iter().find(|rule| rule.1 == degree);
        let &(on_sphere, _) = rule.ok_or(Error::Parameter {
            name: "the degree of a Lebedev rule",
            range: "odd, from 3 to 31 or 35, 41, ..., 131",
            got: degree as f64,
        })?;
        let n_nodes = match domain {
            Domain::Sphere => on_sphere,
            Domain::Hemisphere => on_sphere / 2,
        };
        Ok(Self { n_nodes, degree, domain })
    }
}

impl Rule for LebedevRule {
    fn node_domain(&self) -> Domain {
        self.domain
    }

    fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    fn exact_degree(&self) -> usize {
        self.degree
    }

    fn nodes(&self, set: &mut PointSet) -> Result<(), Error> {
        let degree = self.degree.to_string();
        for line in ORBITS.lines() {
            let Some(numbers) = line.strip_prefix(&*degree).and_then(|s| s.strip_prefix(','))
            else {
                continue;
            };
            let mut numbers = numbers.split(',').filter_map(|number| number.parse().ok());
            if let [Some(a), Some(b), Some(c), Some(weight)] = [(); 4].map(|()| numbers.next()) {
                set.points.extend(orbit([a, b, c]).filter(|&p| is_kept(self.domain, p)));
                set.weights.resize(set.points.len(), weight);
            }
        }
        Ok(())
    }
}

/// Returns the distinct images of a point under the octahedral group: permutations and signs.
fn orbit(p: [f64; 3]) -> impl Iterator<Item = DVec3> {
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let images = orders.map(|order| DVec3::from_array(order.map(|i| p[i])));
    let distinct =
        (0..6).filter(move |&k| !images[..k].contains(&images[k])).map(move |k| images[k]);
    distinct.flat_map(|p| {
        (0..8u8).filter_map(move |signs| {
            let is_flipped = [0, 1, 2].map(|i| signs >> i & 1 == 1);
            // The sign of 0 makes no second point.
            let repeats = (0..3).any(|i| is_flipped[i] && p[i] <= 0.0);
            let signed = |i: usize| if is_flipped[i] { -p[i] } else { p[i] };
            (!repeats).then(|| DVec3::new(signed(0), signed(1), signed(2)))
        })
    })
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "0 for l to about sqrt(3N)",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Lebedev and Laikov 1999",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        let counts = match domain {
            Domain::Sphere => &COUNTS,
            Domain::Hemisphere => &HALF_COUNTS,
        };
        ValidCounts::Listed(Cow::Borrowed(counts))
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let k = self.valid_counts(domain).count_not_exceeding(n_points);
        let (_, degree) = RULES[k.clamp(1, RULES.len()) - 1];
        Ok(Box::new(LebedevRule::new(degree, domain)?))
    }
}
