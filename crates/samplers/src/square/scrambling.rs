//! Scrambling of the digits of patterns: random permutations of digits in base 2 and base 3.

use rand::Rng;
use sphvar_grammar::Choice;

use crate::SquareDistribution;

/// The randomization of the digits of a pattern of the square; points of every realization keep
/// their strata.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scrambling {
    /// The pattern of the definition.
    None,
    /// A random digital shift: the same random number is added to the digit in one place of all
    /// points, modulo the base.
    Digital,
    /// Nested uniform scrambling (Owen 1995): a digit is permuted by a uniform random permutation
    /// that depends on all preceding digits.
    Owen,
}

impl Choice for Scrambling {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("none", Self::None), ("digital", Self::Digital), ("owen", Self::Owen)];
}

impl Scrambling {
    /// Returns the distribution of the sets of a pattern that is not random by itself.
    pub(super) fn distribution(self) -> SquareDistribution<'static> {
        match self {
            Self::None => SquareDistribution::Fixed,
            Self::Digital | Self::Owen => SquareDistribution::Random,
        }
    }
}

/// Returns nested uniformly scrambled binary digits, the first in the highest bit, of a point that
/// has the first `depth` digits in common with the point of the scrambled digits `parent` and no
/// more with any point before it.
///
/// The digits in common are scrambled alike, the next one to the other value than that of the parent,
/// and those that follow independently: they are the bits of `random`.
pub(super) fn branch(parent: u64, depth: u32, random: u64) -> u64 {
    let digit = 1 << (63 - depth);
    (parent ^ digit) & !(digit - 1) | random & (digit - 1)
}

/// 3^33: multiples of its inverse are about as fine as the coordinates of `f64`, and exact.
const WHOLE: u64 = 3_u64.pow(33);

/// Returns the number in [0, 1) of a multiple of 3^-33.
pub(super) fn ternary_fraction(multiple: u64) -> f64 {
    // Both are below 2^53.
    multiple as f64 / WHOLE as f64
}

/// Returns a whole number from 0 to `below - 1` from random bits.
fn scaled(random: u64, below: u64) -> u64 {
    let product = u128::from(random) * u128::from(below);
    (product >> 64) as u64
}

/// The nested uniformly scrambled radical inverses in base 3 of 0, 1, 2, ..., as multiples of 3^-33.
///
/// Number i = d 3^k + r with the highest digit d in place k has the first k digits of its inverse in
/// common with r, and no more with any smaller number, except for d = 2 with r + 3^k, whose digit is
/// the other one of the two that differ from that of r.
#[derive(Debug)]
pub(super) struct ScrambledTernary {
    inverses: Vec<u64>,
    /// 3^k for the place k of the highest digit of the next number; 1 for 0.
    first: usize,
    /// The value 3^(32-k) of that digit in the inverse.
    unit: u64,
}

impl ScrambledTernary {
    pub(super) fn with_capacity(n: usize) -> Self {
        Self { inverses: Vec::with_capacity(n), first: 1, unit: WHOLE / 3 }
    }

    /// Returns the scrambled inverse of the next number, whose random digits are from `random`.
    pub(super) fn next(&mut self, random: u64) -> u64 {
        let i = self.inverses.len();
        let inverse = if i == 0 { scaled(random, WHOLE) } else { self.branch(i, random) };
        self.inverses.push(inverse);
        inverse
    }

    fn branch(&mut self, i: usize, random: u64) -> u64 {
        if i == 3 * self.first {
            self.first = i;
            self.unit /= 3;
        }
        let digits = |number: usize| self.inverses[number] / self.unit;
        let second = self.first..2 * self.first;
        let (shared, digit) = if second.contains(&i) {
            let shared = digits(i - self.first);
            (shared, (shared + 1 + (random >> 63)) % 3)
        } else {
            let shared = digits(i - second.end);
            (shared, 3 - shared % 3 - digits(i - self.first) % 3)
        };
        // The highest bit may be that of the digit.
        (shared - shared % 3 + digit) * self.unit + scaled(random << 1, self.unit)
    }
}

/// The radical inverses in base 3 under a random digital shift, as multiples of 3^-33.
#[derive(Debug)]
pub(super) struct ShiftedTernary {
    /// The value in the inverse of each digit in each place of a number, and of the digits of the
    /// shift in all higher places.
    places: [([u64; 3], u64); MAX_DIGITS],
    shift: u64,
}

/// The number of ternary digits of 2^32 - 1.
const MAX_DIGITS: usize = 21;

impl ShiftedTernary {
    pub(super) fn draw(rng: &mut dyn Rng) -> Self {
        let shift = scaled(rng.next_u64(), WHOLE);
        let (mut unit, mut below) = (WHOLE, shift);
        let places = [(); MAX_DIGITS].map(|()| {
            unit /= 3;
            let digit = below / unit;
            below -= digit * unit;
            ([0, 1, 2].map(|d| (digit + d) % 3 * unit), below)
        });
        Self { places, shift }
    }

    /// Returns the shifted inverse of `i`.
    pub(super) fn inverse(&self, i: u32) -> u64 {
        let (mut rest, mut sum, mut below) = (i, 0, self.shift);
        for (digits, higher) in &self.places {
            if rest == 0 {
                break;
            }
            sum += digits[(rest % 3) as usize];
            below = *higher;
            rest /= 3;
        }
        sum + below
    }
}
