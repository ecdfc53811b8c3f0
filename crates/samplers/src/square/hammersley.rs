use rand::Rng;

use super::POINTS_PER_TICK;
use super::radical_inverse::{base_2, fraction};
use super::scrambled_pattern::{ScrambledParameters, ScrambledPattern};
use super::scrambling::{Scrambling, branch};
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, SquareDistribution, SquareSampler,
    count,
};

/// The Hammersley set of N points in base 2 (Hammersley 1960).
///
/// Point i is `((i + 1/2)/N, phi_2(i))` with the radical inverse phi. For N = 2^m it has one point in
/// every elementary interval of area 2^-m; [`Scrambling`] of the binary digits of both coordinates
/// keeps that property. Without it the set is not random; [`Shifted`](crate::Shifted) makes it so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hammersley {
    n: u32,
    scrambling: Scrambling,
}

impl Hammersley {
    /// Returns the pattern of `n_points` points without scrambling.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Self::scrambled(n_points, Scrambling::None)
    }

    /// Returns the first 64 binary digits of (i + 1/2)/N.
    #[expect(clippy::cast_possible_truncation, reason = "below 2^64")]
    fn first_coordinate(&self, i: u32) -> u64 {
        ((2 * u128::from(i) + 1) << 63).div_euclid(u128::from(self.n)) as u64
    }
}

impl SquareSampler for Hammersley {
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
        let n = f64::from(self.n);
        let shift = match self.scrambling {
            Scrambling::Digital => [rng.next_u64(), rng.next_u64()],
            Scrambling::None | Scrambling::Owen => [0; 2],
        };
        let mut previous = 0;
        let mut second: Vec<u64> = Vec::new();
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            points.push(match self.scrambling {
                Scrambling::None => [(f64::from(i) + 0.5) / n, base_2(i)],
                Scrambling::Digital => {
                    let digits = [self.first_coordinate(i), u64::from(i.reverse_bits()) << 32];
                    [0, 1].map(|d| fraction(digits[d] ^ shift[d]))
                }
                Scrambling::Owen => {
                    let words = [rng.next_u64(), rng.next_u64()];
                    let digits = i.checked_ilog2().map_or(words, |k| {
                        // The point before, in the order of the coordinate, has more digits in
                        // common than any other point so far.
                        let common = self.first_coordinate(i) ^ self.first_coordinate(i - 1);
                        [
                            branch(previous, common.leading_zeros(), words[0]),
                            branch(second[(i ^ 1 << k) as usize], k, words[1]),
                        ]
                    });
                    previous = digits[0];
                    second.push(digits[1]);
                    digits.map(fraction)
                }
            });
        }
        Ok(())
    }
}

impl ScrambledPattern for Hammersley {
    const SCRAMBLING: Scrambling = Scrambling::None;

    fn scrambled(n_points: usize, scrambling: Scrambling) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, scrambling })
    }

    fn facts(scrambling: Scrambling) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            // Faster for N = 2^m.
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: match scrambling {
                Scrambling::Owen => "Hammersley 1960; Owen 1995",
                Scrambling::None | Scrambling::Digital => "Hammersley 1960",
            },
        }
    }
}

/// Parameters of the pattern [`Hammersley`] of the square.
pub type SquareHammersleyParameters = ScrambledParameters<Hammersley>;
