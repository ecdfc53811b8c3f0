use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, PatternFacts, Rate, SobolSequence, SphereMap};

/// Parameters of the pattern [`SobolSequence`] on the sphere.
pub type SobolParameters = MappedParameters<SobolSequence>;

impl MappedPattern for SobolSequence {
    const RANDOMIZATION: Randomization = Randomization::Owen;

    fn facts_on_sphere(_: Randomization, _: SphereMap) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.7),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Sobol 1967; Owen 1995",
        }
    }
}
