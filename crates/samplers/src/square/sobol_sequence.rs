use rand::Rng;
use sphvar_grammar::Parametric;

use super::POINTS_PER_TICK;
use super::radical_inverse::fraction;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, Square, SquareSampler, count,
};

/// The sequence of Sobol in two dimensions (Sobol 1967) under nested uniform scrambling (Owen 1995),
/// drawn point by point: the first points of a realization do not depend on the number of points.
///
/// The first coordinate is the radical inverse in base 2, the second has Pascal's triangle modulo 2
/// as its generator matrix; together they are a (0, 2)-sequence: of the first 2^m points, every
/// elementary interval of area 2^-m holds one. Scrambling preserves this property and makes every
/// point uniform in the square.
///
/// The digits of a coordinate are flipped by random bits, each of which depends on all preceding
/// digits. Every point draws a word of bits for each coordinate; the flip of a digit comes from the
/// word of the first point of the sequence that has the same preceding digits, which is the point
/// itself from the digit on that distinguishes it from all points before it. The cost is at most 32
/// steps and 16 bytes per point.
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
#[derive(Clone, Copy, Debug)]
pub struct SobolSequence {
    n: u32,
}

impl SobolSequence {
    /// Returns the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for SobolSequence {
    fn n_points(&self) -> usize {
        self.n as usize
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
        let mut words: Vec<[u64; 2]> = Vec::with_capacity(self.n_points());
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            words.push([rng.next_u64(), rng.next_u64()]);
            // The columns of the inverse generator matrices, modulo 2: the identity, and Pascal's
            // triangle, which is its own inverse.
            let u = scrambled(i, i.reverse_bits(), |column| column << 1, |j| words[j][0]);
            let v = scrambled(i, second_coordinate(i), |c| c ^ c << 1, |j| words[j][1]);
            points.push([fraction(u), fraction(v)]);
        }
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<Square> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            // Owen 1997, for N = 2^m; about N^-2 for other N.
            smooth_rate: Rate::Power { exponent: -3.0, logarithm: 1.0 },
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Sobol 1967; Owen 1995",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(SobolSequence::new(n_points)?))
    }
}

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

/// Returns the scrambled digits of a coordinate of point `i`; the first digit is the highest bit.
///
/// `next` returns the column of the inverse generator matrix that follows a column, with row 0 in
/// the lowest bit; `word` returns the random bits of a point.
fn scrambled(i: u32, digits: u32, next: impl Fn(u32) -> u32, word: impl Fn(usize) -> u64) -> u64 {
    // Among the first 2^l points, each string of l digits occurs once.
    let shared = u32::BITS - i.leading_zeros();
    let (mut first, mut column, mut flips) = (0, 1, 0);
    for level in 0..shared {
        flips |= word(first as usize) & 1 << (63 - level);
        if digits >> (31 - level) & 1 == 1 {
            first ^= column;
        }
        column = next(column);
    }
    flips |= word(i as usize) & u64::MAX >> shared;
    u64::from(digits) << 32 ^ flips
}

#[cfg(test)]
mod tests {
    use super::{scrambled, second_coordinate};

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

    /// The flip of every digit comes from the first point with the same preceding digits, found by
    /// a search.
    #[test]
    fn flips_are_shared_by_points_with_equal_digits() {
        // A word that tells which point it is of, at every digit: bit 63 - l of hash(j).
        let word = |j: usize| (j as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(17);
        let pascal = |c: u32| c ^ c << 1;
        for i in (0..200).chain([1000, 1023, 1024]) {
            for coordinate in [0, 1] {
                let digits_of =
                    |i: u32| if coordinate == 0 { i.reverse_bits() } else { second_coordinate(i) };
                let mut expected = u64::from(digits_of(i)) << 32;
                for level in 0..64 {
                    let shares = |j: &u32| {
                        let differ = u64::from(digits_of(i) ^ digits_of(*j)) << 32;
                        differ.checked_shr(64 - level).unwrap_or(0) == 0
                    };
                    let first = (0..=i).find(shares).unwrap();
                    expected ^= word(first as usize) & 1 << (63 - level);
                }
                let digits = digits_of(i);
                let got = match coordinate {
                    0 => scrambled(i, digits, |c| c << 1, word),
                    _ => scrambled(i, digits, pascal, word),
                };
                assert_eq!(got, expected, "i = {i}, coordinate {coordinate}");
            }
        }
    }
}
