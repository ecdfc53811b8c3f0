use rand::Rng;

use super::POINTS_PER_TICK;
use super::radical_inverse::{base_2, base_3, fraction};
use super::scrambled_pattern::{ScrambledParameters, ScrambledPattern};
use super::scrambling::{ScrambledTernary, Scrambling, ShiftedTernary, branch, ternary_fraction};
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, SquareDistribution, SquareSampler,
    count,
};

/// The first N points of the Halton sequence in bases 2 and 3 (Halton 1960).
///
/// Point i, from 0, is `(phi_2(i), phi_3(i))` with the radical inverses phi. Of any 2^a 3^b
/// consecutive points of which the first has a multiple of that number as its index, every cell of a
/// grid of 2^a x 3^b has one; [`Scrambling`] keeps that property. Without it the set is not random;
/// [`Shifted`](crate::Shifted) makes it so. The points of a realization do not depend on N. The cost
/// of nested uniform scrambling is 16 bytes and two divisions per point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halton {
    n: u32,
    scrambling: Scrambling,
}

impl Halton {
    /// Returns the pattern of the first `n_points` points without scrambling.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Self::scrambled(n_points, Scrambling::None)
    }

    /// Returns the function that generates the points in turn.
    fn generator<'a>(&self, rng: &'a mut dyn Rng) -> Box<dyn FnMut(u32) -> [f64; 2] + 'a> {
        match self.scrambling {
            Scrambling::None => Box::new(|i| [base_2(i), base_3(i)]),
            Scrambling::Digital => {
                let binary = rng.next_u64();
                let ternary = ShiftedTernary::draw(rng);
                Box::new(move |i| {
                    let digits = u64::from(i.reverse_bits()) << 32 ^ binary;
                    [fraction(digits), ternary_fraction(ternary.inverse(i))]
                })
            }
            Scrambling::Owen => {
                let mut binary: Vec<u64> = Vec::with_capacity(self.n_points());
                let mut ternary = ScrambledTernary::with_capacity(self.n_points());
                Box::new(move |i| {
                    let words = [rng.next_u64(), rng.next_u64()];
                    let digits = i
                        .checked_ilog2()
                        .map_or(words[0], |k| branch(binary[(i ^ 1 << k) as usize], k, words[0]));
                    binary.push(digits);
                    [fraction(digits), ternary_fraction(ternary.next(words[1]))]
                })
            }
        }
    }
}

impl SquareSampler for Halton {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        self.scrambling.distribution()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        points.reserve(self.n_points());
        let mut point = self.generator(rng);
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            points.push(point(i));
        }
        Ok(())
    }
}

impl ScrambledPattern for Halton {
    const SCRAMBLING: Scrambling = Scrambling::None;

    fn scrambled(n_points: usize, scrambling: Scrambling) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, scrambling })
    }

    fn facts(scrambling: Scrambling) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: match scrambling {
                Scrambling::Owen => "Halton 1960; Owen 1995",
                Scrambling::None | Scrambling::Digital => "Halton 1960",
            },
        }
    }
}

/// Parameters of the pattern [`Halton`] of the square.
pub type SquareHaltonParameters = ScrambledParameters<Halton>;
