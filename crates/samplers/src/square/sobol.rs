use rand::Rng;

use crate::{Error, PointSet, SquareSampler, count};

/// Number of binary digits of a coordinate: those of an evenly spaced `f64` in [0, 1).
const DIGITS: u32 = 53;

/// The first N points of Sobol's sequence in two dimensions (Sobol 1967) under nested uniform
/// scrambling (Owen 1995).
///
/// The first coordinate is the radical inverse in base 2, the second has Pascal's triangle modulo 2
/// as its generator matrix; together they are a (0, 2)-sequence: of the first 2^m points, every
/// elementary interval of area 2^-m holds one. Scrambling preserves this property and makes every
/// point uniform in the square.
///
/// The scrambling is that of Owen, not its approximation by a hash: each digit is flipped by a
/// random bit that depends on all preceding digits. With 2^m >= N no two points share their first m
/// digits in either coordinate, so that 2^m - 1 bits per coordinate hold every flip that two points
/// can share, and the digits beyond are independent random bits, down to 2^-53. The cost is 2m
/// steps per point and 2^(m+1) bits. The bits depend on m: [`SobolSequence`](crate::SobolSequence)
/// has the same distribution, and its points do not depend on N.
///
/// ```
/// use sphvar_samplers::{Purpose, Sobol, SquareSampler, Streams};
/// let mut rng = Streams::new(0, Purpose::Pattern, 16).realization(0);
/// let points = Sobol::new(16)?.sample(&mut rng)?.points;
/// // One point in each cell of a 4 x 4 grid.
/// let mut cells: Vec<_> = points.iter().map(|p| p.map(|x| (4.0 * x) as u8)).collect();
/// cells.sort();
/// cells.dedup();
/// assert_eq!(cells.len(), 16);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    n: u32,
}

impl Sobol {
    /// Returns the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for Sobol {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        let levels = u32::BITS - (self.n - 1).leading_zeros();
        let scrambles = [Scramble::draw(levels, rng), Scramble::draw(levels, rng)];
        set.start().extend((0..self.n).map(|i| {
            let digits = [i.reverse_bits(), second_coordinate(i)];
            [0, 1].map(|d: usize| scrambles[d].apply(digits[d], rng))
        }));
        Ok(())
    }
}

/// Returns the digits of the second coordinate of point `i`, with the first digit in the highest
/// bit.
pub(super) fn second_coordinate(i: u32) -> u32 {
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

/// The random flips of one coordinate: a bit for every string of fewer than `levels` digits.
struct Scramble {
    levels: u32,
    /// The tree in heap order: the empty string is 1, appending digit b to s is 2s + b.
    flips: Vec<u64>,
}

impl Scramble {
    fn draw(levels: u32, rng: &mut dyn Rng) -> Self {
        let words = (1usize << levels).div_ceil(64);
        Self { levels, flips: (0..words).map(|_| rng.next_u64()).collect() }
    }

    /// Returns the scrambled coordinate, in [0, 1), of digits whose first is the highest bit.
    fn apply(&self, digits: u32, rng: &mut dyn Rng) -> f64 {
        let mut prefix = 1u64;
        let mut scrambled = 0u64;
        for level in 1..=self.levels {
            let digit = u64::from(digits >> (32 - level) & 1);
            let flip = self.flips[(prefix / 64) as usize] >> (prefix % 64) & 1;
            scrambled = scrambled << 1 | (digit ^ flip);
            prefix = prefix << 1 | digit;
        }
        let beyond = DIGITS - self.levels;
        let tail = rng.next_u64() >> (64 - beyond);
        (scrambled << beyond | tail) as f64 * 2f64.powi(-53)
    }
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
