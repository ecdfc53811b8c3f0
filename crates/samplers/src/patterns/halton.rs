use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, Halton, PatternFacts, Rate, SphereMap};

/// Parameters of the pattern [`Halton`] on the sphere.
pub type HaltonParameters = MappedParameters<Halton>;

impl MappedPattern for Halton {
    const RANDOMIZATION: Randomization = Randomization::Shift;

    fn facts_on_sphere(_: Randomization, _: SphereMap) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Halton 1960; Cranley and Patterson 1976",
        }
    }
}
