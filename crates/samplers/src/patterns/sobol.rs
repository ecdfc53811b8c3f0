use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, OnSphere, PatternFacts, Rate, Sampler, SobolSequence};

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.7),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Sobol 1967; Owen 1995",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(OnSphere::new(SobolSequence::new(n_points)?, domain)))
    }
}
