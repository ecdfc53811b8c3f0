use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, Hammersley, OnSphere, PatternFacts, Rate, Sampler, Shifted};

/// [`Hammersley`] points with a random shift by the equal-area map: the heights are an
/// arithmetic progression, and the shift of the second coordinate is a rotation about the axis. No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-3.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Hammersley 1960; Cranley and Patterson 1976",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let shifted = Shifted::new(Hammersley::new(n_points)?);
        Ok(Box::new(OnSphere::new(shifted, domain)))
    }
}
