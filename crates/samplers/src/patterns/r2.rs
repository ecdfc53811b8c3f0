use sphvar_grammar::{Choice, Declaration, Parametric};

use super::mapped::declare_map;
use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, R2, Rate, Sampler, Shifted, SphereMap};

/// The randomization of [`R2`], a pattern without digits, before it is mapped to directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum R2Randomization {
    /// The sequence of the definition, always the same.
    None,
    /// A uniform random shift modulo 1 (Cranley and Patterson 1976).
    #[default]
    Shift,
}

impl Choice for R2Randomization {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("shift", Self::Shift)];
}

/// Parameters of the pattern [`R2`] on the sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct R2Parameters {
    /// The randomization on the square.
    pub randomization: R2Randomization,
    /// The map to directions.
    pub map: SphereMap,
}

impl R2Parameters {
    /// The default parameters.
    pub const DEFAULT: Self =
        Self { randomization: R2Randomization::Shift, map: SphereMap::Cylinder };
}

impl Parametric for R2Parameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "randomization on the square, before any rotation";
        d.choice("randomization", summary, &mut self.randomization);
        declare_map(d, &mut self.map);
    }
}

impl Definition for R2Parameters {
    fn facts(&self) -> PatternFacts {
        let [smooth_rate, jump_rate] = match (self.randomization, self.map) {
            (R2Randomization::None, _) => [Rate::Depends; 2],
            (_, SphereMap::Cylinder) => [-1.9, -1.5].map(Rate::power),
            (_, SphereMap::Octahedral) => [-1.7, -1.5].map(Rate::power),
            // Independent shifts on the faces.
            (_, SphereMap::Healpix) => [-1.5, -1.5].map(Rate::power),
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate,
            jump_rate,
            is_extensible: true,
            source: match self.randomization {
                R2Randomization::None => "Roberts 2018",
                R2Randomization::Shift => "Roberts 2018; Cranley and Patterson 1976",
            },
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        match self.randomization {
            R2Randomization::None => self.map.build(n_points, domain, R2::new),
            R2Randomization::Shift => {
                self.map.build(n_points, domain, |n| Ok(Shifted::new(R2::new(n)?)))
            }
        }
    }
}
