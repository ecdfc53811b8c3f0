use std::f64::consts::TAU;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_warps::archimedes;

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution};

/// 2^128 divided by the golden ratio (1 + sqrt 5)/2, rounded down: the longitude's step in turns.
const INVERSE_GOLDEN_RATIO: u128 = 0x9E37_79B9_7F4A_7C15_F39C_C060_5CED_C834;

/// The spherical Fibonacci lattice: point j of N at longitude `2 pi j / golden ratio` and height
///
/// ```text
/// z = 1 - 2 (j + d)/(N - 1 + 2d),   on the hemisphere  z = 1 - (j + d)/(N - 1/2 + d),
/// ```
///
/// with the end offset d. The default 1/2 gives `z = 1 - (2j+1)/N` (Swinbank and Purser 2006;
/// Marques et al. 2013), heights of equal area. Larger offsets move the points away from the poles
/// (Roberts 2020): up to about 3 the smallest distance grows, but integrals of jumps become less
/// accurate because the density at the poles is wrong. The hemisphere has the upper half of the
/// heights of 2N points.
///
/// The longitude is computed in fixed point modulo one turn, so it is exact to rounding for any j.
/// The pattern is deterministic: all realizations are the same set.
#[derive(Clone, Copy, Debug)]
pub struct Fibonacci {
    n_points: usize,
    domain: Domain,
    offset: f64,
}

impl Fibonacci {
    /// Returns the lattice of `n_points` points with the default offset.
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points.
    pub fn new(n_points: usize, domain: Domain) -> Result<Self, Error> {
        Self::with_offset(n_points, domain, FibonacciParameters::DEFAULT.offset)
    }

    /// Returns the lattice of `n_points` points whose ends are `offset` steps of height from the
    /// poles.
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points; [`Error::Parameter`] unless `offset` is in [0, 1e6].
    pub fn with_offset(n_points: usize, domain: Domain, offset: f64) -> Result<Self, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: "fibonacci".to_owned() });
        }
        if !(0.0..=FibonacciParameters::MAX_OFFSET).contains(&offset) {
            return Err(Error::Parameter {
                name: "the offset of fibonacci",
                range: "in [0, 1e6]",
                got: offset,
            });
        }
        Ok(Self { n_points, domain, offset })
    }

    /// Returns the points of the lattice.
    pub(crate) fn points(self) -> impl Iterator<Item = DVec3> {
        let ends = 2.0 * self.offset;
        // With the default offset this is the number of points on the sphere, without rounding.
        let span = (self.domain.count_on_sphere(self.n_points) - 1.0) + ends;
        (0..self.n_points).map(move |j| {
            // A single point without an offset is between the poles, as with any other offset.
            let drop = if span > 0.0 { ((2 * j) as f64 + ends) * (1.0 / span) } else { 1.0 };
            archimedes(drop, TAU * golden_turns(j))
        })
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
        set.start().extend(self.points());
        Ok(())
    }
}

/// Parameters of the pattern [`Fibonacci`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibonacciParameters {
    /// The offset of the ends from the poles, in steps of height.
    pub offset: f64,
}

impl FibonacciParameters {
    /// The default parameters: the centres of N zones of equal area.
    pub const DEFAULT: Self = Self { offset: 0.5 };

    const MAX_OFFSET: f64 = 1e6;
}

impl Default for FibonacciParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for FibonacciParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::closed(0.0, Self::MAX_OFFSET);
        let summary = "distance of the first and last point from the poles, in steps of height";
        d.number("offset", range, summary, &mut self.offset);
    }
}

impl Definition for FibonacciParameters {
    fn facts(&self) -> PatternFacts {
        let is_default = *self == Self::DEFAULT;
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: if is_default { "irregular, N^-2 to N^-4" } else { "irregular" },
            smooth_rate: if is_default { Rate::power(-3.0) } else { Rate::Depends },
            jump_rate: if is_default { Rate::power(-1.5) } else { Rate::Depends },
            is_extensible: false,
            source: if is_default { "Gonzalez 2010" } else { "Roberts 2020" },
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(Fibonacci::with_offset(n_points, domain, self.offset)?))
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
