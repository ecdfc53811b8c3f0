//! Patterns of the square that are mapped to directions of known densities.

mod patterns;
mod predictions;
mod rare_values;
mod strategies;
mod trials;

use sphvar_integrands::{
    Domain, EnvironmentMap, EnvironmentParameters, Expression, Integrand, IntegrandResolver,
    PulledBack, Tolerance, grammar::ResolveError,
};
use sphvar_variance::WarpedPattern;

/// A map of 8 x 4 texels, whatever the name of the file.
struct Map;

impl IntegrandResolver for Map {
    fn environment(&self, _: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        let texels = (0..32).map(|i| 1.0 + f64::from(i * i % 11)).collect();
        Ok(EnvironmentMap::new(8, 4, texels).unwrap())
    }
}

fn integrand(text: &str) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(&Map).unwrap()
}

fn warped(text: &str) -> WarpedPattern {
    text.parse().unwrap()
}

fn pulled_back<'a>(
    function: &'a dyn Integrand,
    domain: Domain,
    pattern: &WarpedPattern,
) -> Vec<PulledBack<'a>> {
    let strategies = pattern.warp.strategies(domain, &Map).unwrap();
    // Fewer values than those of predictions, whose errors the tests allow for.
    let tolerance =
        Tolerance { relative: 1e-2, min_evaluations: 1 << 12, max_evaluations: 1 << 15 };
    PulledBack::of_strategies(function, domain, &strategies, pattern.heuristic, tolerance).unwrap()
}
