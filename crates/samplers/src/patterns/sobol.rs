use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, PatternFacts, Rate, SobolSequence, SphereMap};

/// Parameters of the pattern [`SobolSequence`] on the sphere.
pub type SobolParameters = MappedParameters<SobolSequence>;

impl MappedPattern for SobolSequence {
    const RANDOMIZATION: Randomization = Randomization::Owen;

    fn facts_on_sphere(randomization: Randomization, map: SphereMap) -> PatternFacts {
        // For N = 2^m, with map=healpix 12 4^k; about N^-2 for other N.
        let [smooth_rate, jump_rate] = match (randomization, map) {
            (Randomization::Owen, _) => [-2.7, -1.5].map(Rate::power),
            (Randomization::Digital, SphereMap::Cylinder) => [-2.6, -1.5].map(Rate::power),
            (Randomization::Shift, SphereMap::Cylinder) => [-2.6, -1.4].map(Rate::power),
            (Randomization::None, SphereMap::Cylinder) => [-2.4, -1.5].map(Rate::power),
            _ => [Rate::Depends; 2],
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate,
            jump_rate,
            is_extensible: true,
            source: match randomization {
                Randomization::Owen => "Sobol 1967; Owen 1995",
                Randomization::Shift => "Sobol 1967; Cranley and Patterson 1976",
                Randomization::Digital | Randomization::None => "Sobol 1967",
            },
        }
    }
}
