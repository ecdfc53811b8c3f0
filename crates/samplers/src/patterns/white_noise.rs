use std::f64::consts::TAU;

use glam::DVec3;
use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;
use sphvar_warps::archimedes;

use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution};

/// Independent, uniformly distributed directions: `P(l) = 1` for every l >= 1, variance
/// `(area int F^2 - (int F)^2)/N`.
#[derive(Clone, Copy, Debug)]
pub struct WhiteNoise {
    n_points: usize,
    domain: Domain,
}

impl WhiteNoise {
    pub(crate) fn new(n_points: usize, domain: Domain) -> Self {
        Self { n_points, domain }
    }
}

impl Sampler for WhiteNoise {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Independent
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        points.reserve(self.n_points);
        let mut bytes = [0; BLOCK * BYTES_PER_POINT];
        let mut missing = self.n_points;
        while missing > 0 {
            let block = missing.min(BLOCK);
            missing -= block;
            let (pairs, _) = bytes[..block * BYTES_PER_POINT].as_chunks_mut::<BYTES_PER_POINT>();
            rng.fill_bytes(pairs.as_flattened_mut());
            points.extend(pairs.iter().map(|pair| {
                let (words, _) = pair.as_chunks();
                direction_of(self.domain, uniform(words[0]), uniform(words[1]))
            }));
        }
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
            low_degrees: "1",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: true,
            source: "definition",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(WhiteNoise::new(n_points, domain)))
    }
}

/// Number of points whose random bytes are requested at once: a virtual call of the generator for
/// each number takes a tenth of the time.
const BLOCK: usize = 64;

/// Two words of 8.
const BYTES_PER_POINT: usize = 16;

/// Returns the uniform number in [0, 1) that `rand` derives from a random word: its upper 53 bits.
fn uniform(word: [u8; 8]) -> f64 {
    (u64::from_le_bytes(word) >> 11) as f64 * (0.5 * f64::EPSILON)
}

/// Returns a uniformly distributed direction of `domain`.
pub(crate) fn uniform_direction(domain: Domain, rng: &mut dyn Rng) -> DVec3 {
    let (u, v) = (rng.random(), rng.random());
    direction_of(domain, u, v)
}

#[inline]
fn direction_of(domain: Domain, u: f64, v: f64) -> DVec3 {
    let height = match domain {
        Domain::Sphere => 2.0,
        Domain::Hemisphere => 1.0,
    };
    archimedes(height * u, TAU * v)
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, Domain, Sampler, WhiteNoise, uniform_direction};
    use crate::{Purpose, Streams};
    use rand::Rng;

    #[test]
    fn directions_in_blocks_match_single_directions() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for n in [1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 10 * BLOCK + 7] {
                for skipped in 0..2 {
                    let start = || {
                        let mut rng = Streams::new(4, Purpose::Pattern, n).realization(0);
                        // Half a word leaves the generator between two words.
                        (0..skipped).for_each(|_| _ = rng.next_u32());
                        rng
                    };
                    let (mut rng, mut one_by_one) = (start(), start());
                    let points = WhiteNoise::new(n, domain).sample(&mut rng).unwrap().points;
                    for (k, p) in points.iter().enumerate() {
                        let q = uniform_direction(domain, &mut one_by_one);
                        assert_eq!(*p, q, "{domain}, point {k} of {n}");
                    }
                    // The next draw, a rotation, is also the same.
                    assert_eq!(rng.next_u64(), one_by_one.next_u64(), "{domain} {n}");
                }
            }
        }
    }
}
