use std::f64::consts::TAU;

use rand::Rng;
use sphvar_grammar::Parametric;
use sphvar_warps::archimedes;

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution};

/// 2^128 divided by the golden ratio (1 + sqrt 5)/2, rounded down: the longitude's step in turns.
const INVERSE_GOLDEN_RATIO: u128 = 0x9E37_79B9_7F4A_7C15_F39C_C060_5CED_C834;

/// The spherical Fibonacci lattice: point j at height `z = 1 - (2j+1)/N` (on the hemisphere
/// `1 - (2j+1)/(2N)`) and longitude `2 pi j / golden ratio` (Swinbank and Purser 2006; Marques et
/// al. 2013).
///
/// The longitude is computed in fixed point modulo one turn, so it is exact to rounding for any j.
/// The pattern is deterministic: all realizations are the same set.
#[derive(Clone, Copy, Debug)]
pub struct Fibonacci {
    n_points: usize,
    domain: Domain,
}

impl Fibonacci {
    pub(crate) fn new(n_points: usize, domain: Domain) -> Self {
        Self { n_points, domain }
    }
}

impl Sampler for Fibonacci {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        let per_point = match self.domain {
            Domain::Sphere => 1.0 / self.n_points as f64,
            Domain::Hemisphere => 0.5 / self.n_points as f64,
        };
        points.extend((0..self.n_points).map(|j| {
            let drop = (2 * j + 1) as f64 * per_point;
            archimedes(drop, TAU * golden_turns(j))
        }));
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular, N^-2 to N^-4",
            smooth_rate: Rate::power(-3.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Gonzalez 2010",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(Fibonacci::new(n_points, domain)))
    }
}

/// Returns the fractional part, in [0, 1) turns, of `j` golden steps.
fn golden_turns(j: usize) -> f64 {
    let turns = (j as u128).wrapping_mul(INVERSE_GOLDEN_RATIO);
    (turns >> 75) as f64 * 2f64.powi(-53)
}

#[cfg(test)]
mod tests {
    use super::golden_turns;

    #[test]
    fn the_longitude_is_the_inverse_golden_ratio_mod_one() {
        let ratio = f64::midpoint(5f64.sqrt(), 1.0);
        for j in 0..2000u32 {
            let plain = (f64::from(j) / ratio).fract();
            let fixed = golden_turns(j as usize);
            // The plain product is accurate to j EPSILON; 0 and 1 are the same angle.
            let off = (plain - fixed).abs();
            let off = off.min(1.0 - off);
            assert!(off <= f64::EPSILON * (f64::from(j) + 1.0), "j = {j}: {plain} and {fixed}");
        }
        // Fibonacci numbers of steps return close to the start: |F_k/ratio - F_(k-1)| = ratio^-k.
        let (mut a, mut b, mut k) = (1usize, 1usize, 2);
        while b < 1 << 40 {
            (a, b, k) = (b, a + b, k + 1);
            let turns = golden_turns(b);
            let off = turns.min(1.0 - turns);
            let exact = ratio.powi(-k);
            assert!((off - exact).abs() < 2f64.powi(-52), "F_{k} = {b}: {off} and {exact}");
        }
    }
}
