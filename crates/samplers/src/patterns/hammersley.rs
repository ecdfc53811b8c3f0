use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, Hammersley, PatternFacts, Rate, SphereMap};

/// Parameters of the pattern [`Hammersley`] on the sphere.
pub type HammersleyParameters = MappedParameters<Hammersley>;

impl MappedPattern for Hammersley {
    const RANDOMIZATION: Randomization = Randomization::Shift;

    fn facts_on_sphere(randomization: Randomization, map: SphereMap) -> PatternFacts {
        let [smooth_rate, jump_rate] = match (randomization, map) {
            (Randomization::Shift, SphereMap::Cylinder) => [-3.0, -1.5].map(Rate::power),
            (Randomization::Shift, SphereMap::Octahedral) => [-2.0, -1.5].map(Rate::power),
            (Randomization::Shift, SphereMap::Healpix) => [-1.9, -1.5].map(Rate::power),
            (Randomization::Digital, SphereMap::Cylinder) => [-2.0, -1.5].map(Rate::power),
            // For N = 2^m; about N^-2 for other N.
            (Randomization::Owen, SphereMap::Cylinder) => [-2.6, -1.5].map(Rate::power),
            _ => [Rate::Depends; 2],
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate,
            jump_rate,
            is_extensible: false,
            source: match randomization {
                Randomization::Owen => "Hammersley 1960; Owen 1995",
                Randomization::Shift => "Hammersley 1960; Cranley and Patterson 1976",
                Randomization::Digital | Randomization::None => "Hammersley 1960",
            },
        }
    }
}
