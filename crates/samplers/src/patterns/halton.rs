use super::{MappedParameters, MappedPattern, Randomization};
use crate::{CostOrder, Halton, PatternFacts, Rate, SphereMap};

/// Parameters of the pattern [`Halton`] on the sphere.
pub type HaltonParameters = MappedParameters<Halton>;

impl MappedPattern for Halton {
    const RANDOMIZATION: Randomization = Randomization::Shift;

    fn facts_on_sphere(randomization: Randomization, map: SphereMap) -> PatternFacts {
        let [smooth_rate, jump_rate] = match (randomization, map) {
            (Randomization::None, _) => [Rate::Depends; 2],
            (_, SphereMap::Cylinder) | (Randomization::Owen, SphereMap::Healpix) => {
                [-2.0, -1.5].map(Rate::power)
            }
            _ => [Rate::Depends; 2],
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate,
            jump_rate,
            is_extensible: true,
            source: match randomization {
                Randomization::Owen => "Halton 1960; Owen 1995",
                Randomization::Shift => "Halton 1960; Cranley and Patterson 1976",
                Randomization::Digital | Randomization::None => "Halton 1960",
            },
        }
    }
}
