use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, Hammersley, PatternFacts, Rate, SphereMap};

/// Parameters of the pattern [`Hammersley`] on the sphere.
pub type HammersleyParameters = MappedParameters<Hammersley>;

impl MappedPattern for Hammersley {
    const RANDOMIZATION: Randomization = Randomization::Shift;

    fn facts_on_sphere(_: Randomization, _: SphereMap) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-3.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Hammersley 1960; Cranley and Patterson 1976",
        }
    }
}
