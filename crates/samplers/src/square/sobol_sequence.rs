use rand::Rng;

use super::POINTS_PER_TICK;
use super::radical_inverse::fraction;
use super::scrambled_pattern::{ScrambledParameters, ScrambledPattern};
use super::scrambling::{Scrambling, branch};
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, SquareDistribution, SquareSampler,
    count,
};

/// The sequence of Sobol in two dimensions (Sobol 1967), by default under nested uniform scrambling
/// (Owen 1995), drawn point by point: the first points of a realization do not depend on the number
/// of points.
///
/// The first coordinate is the radical inverse in base 2, the second has Pascal's triangle modulo 2
/// as its generator matrix; together they are a (0, 2)-sequence: of the first 2^m points, every
/// elementary interval of area 2^-m holds one. Scrambling preserves this property and makes every
/// point uniform in the square.
///
/// In nested uniform scrambling, the digits of a coordinate are flipped by random bits, each of
/// which depends on all preceding digits. For 2^k <= i < 2^(k+1), one of the first 2^k points has
/// the first k digits in common with point i and differs in the next: the scrambled digits follow
/// from those of that point, and all later digits are random. The cost is 16 bytes and a few steps
/// per point.
///
/// ```
/// use sphvar_samplers::{Purpose, SobolSequence, SquareSampler, Streams};
/// let mut rng = Streams::new(0, Purpose::Pattern, 16).realization(0);
/// let points = SobolSequence::new(16)?.sample(&mut rng)?.points;
/// // One point in each cell of a 4 x 4 grid.
/// let mut cells: Vec<_> = points.iter().map(|p| p.map(|x| (4.0 * x) as u8)).collect();
/// cells.sort();
/// cells.dedup();
/// assert_eq!(cells.len(), 16);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SobolSequence {
    n: u32,
    scrambling: Scrambling,
}

impl SobolSequence {
    /// Returns the first `n_points` points under nested uniform scrambling.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Self::scrambled(n_points, Scrambling::Owen)
    }
}

impl SquareSampler for SobolSequence {
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
        let shift = match self.scrambling {
            Scrambling::Digital => [rng.next_u64(), rng.next_u64()],
            Scrambling::None | Scrambling::Owen => [0; 2],
        };
        let mut scrambled: Vec<[u64; 2]> = Vec::new();
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            let digits = if self.scrambling == Scrambling::Owen {
                let words = [rng.next_u64(), rng.next_u64()];
                let digits = i.checked_ilog2().map_or(words, |k| {
                    let parents = [i ^ 1 << k, i ^ PASCAL[k as usize]];
                    [0, 1].map(|d| branch(scrambled[parents[d] as usize][d], k, words[d]))
                });
                scrambled.push(digits);
                digits
            } else {
                let digits = [i.reverse_bits(), second_coordinate(i)];
                [0, 1].map(|d| u64::from(digits[d]) << 32 ^ shift[d])
            };
            points.push(digits.map(fraction));
        }
        Ok(())
    }
}

impl ScrambledPattern for SobolSequence {
    const SCRAMBLING: Scrambling = Scrambling::Owen;

    fn scrambled(n_points: usize, scrambling: Scrambling) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, scrambling })
    }

    fn facts(scrambling: Scrambling) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: match scrambling {
                // Owen 1997, for N = 2^m; about N^-2 for other N.
                Scrambling::Owen => Rate::Power { exponent: -3.0, logarithm: 1.0 },
                Scrambling::None | Scrambling::Digital => Rate::power(-2.0),
            },
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: match scrambling {
                Scrambling::Owen => "Sobol 1967; Owen 1995",
                Scrambling::None | Scrambling::Digital => "Sobol 1967",
            },
        }
    }
}

/// Parameters of the pattern [`SobolSequence`] of the square.
pub type SquareSobolParameters = ScrambledParameters<SobolSequence>;

/// The columns of Pascal's triangle modulo 2: bit r of column k is that of binomial(k, r).
///
/// The triangle is its own inverse, so point `i ^ PASCAL[k]` has the digits of the second coordinate
/// of point i but for digit k, for 2^k <= i < 2^(k+1).
const PASCAL: [u32; 32] = {
    let mut columns = [1; 32];
    let mut k = 1;
    while k < 32 {
        columns[k] = columns[k - 1] ^ columns[k - 1] << 1;
        k += 1;
    }
    columns
};

/// Returns the digits of the second coordinate of point `i`, with the first digit in the highest
/// bit.
fn second_coordinate(i: u32) -> u32 {
    let mut rest = i;
    let mut direction = 1 << 31;
    let mut digits = 0;
    while rest > 0 {
        if rest & 1 == 1 {
            digits ^= direction;
        }
        // Row by row of Pascal's triangle modulo 2.
        direction ^= direction >> 1;
        rest >>= 1;
    }
    digits
}

#[cfg(test)]
mod tests {
    use super::second_coordinate;

    #[test]
    fn the_first_values_of_the_second_coordinate() {
        let values = [0.0, 0.5, 0.75, 0.25, 0.625, 0.125, 0.375, 0.875];
        for (i, expected) in (0..).zip(values) {
            let value = f64::from(second_coordinate(i)) * 2f64.powi(-32);
            assert!((value - expected).abs() <= 0.0, "i = {i}: {value}");
        }
    }

    /// Digit r of the coordinate is the sum over digits c of i of binomial(c, r), modulo 2; by
    /// Lucas's theorem that binomial is odd if the bits of r are a subset of those of c.
    #[test]
    fn the_generator_matrix_is_pascals_triangle() {
        for i in (0..300).chain([1 << 31, u32::MAX, 0xdead_beef]) {
            let digit = |r: u32| (0..32).filter(|c| i >> c & 1 == 1 && c & r == r).count() % 2;
            let expected = (0..32).fold(0u32, |bits, r| bits << 1 | u32::from(digit(r) == 1));
            assert_eq!(second_coordinate(i), expected, "i = {i}");
        }
    }
}
