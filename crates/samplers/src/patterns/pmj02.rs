use sphvar_grammar::{Declaration, Parametric};

use super::mapped::declare_map;
use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, Pmj02, Rate, Sampler, SphereMap};

/// Parameters of the pattern [`Pmj02`] on the sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pmj02Parameters {
    /// The map to directions.
    pub map: SphereMap,
}

impl Pmj02Parameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { map: SphereMap::Cylinder };
}

impl Parametric for Pmj02Parameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        declare_map(d, &mut self.map);
    }
}

impl Definition for Pmj02Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "irregular",
            // For N = 2^m, with map=healpix 12 4^k; about N^-1.8 for other N.
            smooth_rate: Rate::power(-2.6),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Christensen, Kensler and Kilpatrick 2018",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        self.map.build(n_points, domain, Pmj02::new)
    }
}
