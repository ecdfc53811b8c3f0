use super::env::EnvironmentWarpParameters;
use super::{WarpExpression, WarpFactor, WarpTerm};
use crate::{
    CapParameters, Domain, Expression, Factor, HalfSpaceParameters, Interpolation, Summand, Term,
};

impl WarpExpression {
    /// Returns densities that resemble an integrand, the closest first: for each term of a sum its
    /// maps, also times the cosine, its lobes and caps, and the cosine; all terms of a sum, or all
    /// factors of a product, together as strategies with equal shares; and the uniform maps.
    ///
    /// A map is proposed with bilinear interpolation, to which an integrand `env:FILE` is exactly
    /// proportional, and constant on each texel. Files are not read, so a map may turn out to be 0
    /// where the integrand is not.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::{Domain, Expression, WarpExpression};
    ///
    /// let integrand: Expression = "vmf:kappa=50 @ 40/10 * cosine".parse()?;
    /// let proposed = WarpExpression::proposed(&integrand, Domain::Hemisphere);
    /// let texts: Vec<String> = proposed.iter().map(WarpExpression::to_string).collect();
    /// let both = "vmf:kappa=50 @ 40/10 + cosine";
    /// assert_eq!(texts, ["vmf:kappa=50 @ 40/10", "cosine", both, "cylinder", "octahedral"]);
    /// # Ok::<(), sphvar_integrands::Error>(())
    /// ```
    #[must_use]
    pub fn proposed(integrand: &Expression, domain: Domain) -> Vec<Self> {
        let summands = without_filters(integrand);
        let of_summands: Vec<Vec<Self>> =
            summands.iter().map(|summand| of_summand(summand, domain)).collect();
        // The closest density of each term; a constant one for terms without any.
        let uniform = [WarpTerm::Cylinder, WarpTerm::Octahedral].map(unrotated);
        let closest: Vec<Self> =
            of_summands.iter().map(|of| of.first().unwrap_or(&uniform[0]).clone()).collect();
        let mut proposed: Vec<Self> = Vec::new();
        let all = of_summands.into_iter().flatten();
        let together = if closest.len() > 1 { combined(closest) } else { None };
        for warp in all.chain(together).chain(uniform) {
            if !proposed.contains(&warp) {
                proposed.push(warp);
            }
        }
        proposed
    }
}

fn unrotated(term: WarpTerm) -> WarpExpression {
    WarpExpression::product(vec![Factor { term, rotations: Vec::new() }])
}

/// Returns different warps together, if there are several.
fn combined(mut warps: Vec<WarpExpression>) -> Option<WarpExpression> {
    let mut distinct: Vec<WarpExpression> = Vec::new();
    for warp in warps.drain(..) {
        if !distinct.contains(&warp) {
            distinct.push(warp);
        }
    }
    (distinct.len() > 1).then(|| WarpExpression::combined(&distinct).ok())?
}

/// Returns the terms of a sum, those of a filtered sum in its place.
fn without_filters(expression: &Expression) -> Vec<Summand> {
    let mut summands = Vec::new();
    for summand in &expression.summands {
        let [Factor { term: Term::Filtered(filtered), rotations }] = &*summand.factors else {
            summands.push(summand.clone());
            continue;
        };
        for mut inside in without_filters(&filtered.of) {
            for factor in &mut inside.factors {
                factor.rotations.extend(rotations);
            }
            summands.push(inside);
        }
    }
    summands
}

/// Returns the densities that resemble a product, the closest first.
fn of_summand(summand: &Summand, domain: Domain) -> Vec<WarpExpression> {
    let (mut maps, mut lobes, mut cosines) = (Vec::new(), Vec::new(), Vec::new());
    for Factor { term, rotations } in &summand.factors {
        let push = |list: &mut Vec<WarpFactor>, term| {
            list.push(Factor { term, rotations: rotations.clone() });
        };
        match term {
            Term::Environment(environment) => {
                let mut environment = environment.clone();
                // Three channels are sampled from their luminance.
                environment.picture.channel.take_if(|channel| channel == "rgb");
                for interpolation in [Interpolation::Bilinear, Interpolation::Constant] {
                    let environment = environment.clone();
                    let map = EnvironmentWarpParameters { environment, interpolation, floor: 0.0 };
                    push(&mut maps, WarpTerm::Environment(map));
                }
            }
            Term::VonMisesFisher(lobe) => push(&mut lobes, WarpTerm::VonMisesFisher(*lobe)),
            Term::Phong(lobe) => push(&mut lobes, WarpTerm::Phong(*lobe)),
            Term::Cap(cap) => push(&mut lobes, WarpTerm::Cap(*cap)),
            Term::HalfSpace(HalfSpaceParameters { height }) => {
                let degrees = height.acos().to_degrees();
                push(&mut lobes, WarpTerm::Cap(CapParameters { degrees }));
            }
            Term::Cosine => push(&mut cosines, WarpTerm::Cosine),
            Term::AbsCosine if domain == Domain::Hemisphere && rotations.is_empty() => {
                push(&mut cosines, WarpTerm::Cosine);
            }
            _ => {}
        }
    }
    let times_cosine = |map: &WarpFactor| {
        let WarpTerm::Environment(parameters) = &map.term else { return None };
        let cosine = cosines
            .iter()
            .find(|cosine| parameters.angle_to(map.rotation(), cosine.rotation()).is_some())?;
        Some(WarpExpression::product(vec![map.clone(), cosine.clone()]))
    };
    let mut warps: Vec<WarpExpression> = maps.iter().filter_map(times_cosine).collect();
    let single = |factor: &WarpFactor| WarpExpression::product(vec![factor.clone()]);
    warps.extend(maps.iter().chain(&lobes).chain(&cosines).map(single));
    // One density for each factor.
    let factors = maps.iter().step_by(2).chain(&lobes).chain(&cosines);
    warps.extend(combined(factors.map(single).collect()));
    warps
}
