use rand::Rng;
use sphvar_grammar::Parametric;

use super::lattice::gcd;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, Lattice, PatternFacts, PointSet, Rate, Square, SquareDistribution,
    SquareSampler, count,
};

/// The Fibonacci lattice (Zaremba 1966): the rank-1 lattice `(j/N, j g/N mod 1)`, with g the number
/// before N in Fibonacci's sequence if N is one of its numbers.
///
/// For other N, g is the best of the 64 numbers coprime to N that are nearest to N divided by the
/// golden ratio: the one with the largest Zaremba index, the smallest product `max(1, |h1|)
/// max(1, |h2|)` over the nonzero frequencies of the dual lattice, and of several the nearest. For N
/// to 3000 the index is at least `N/6`; no generator guarantees more, since N = 6 has no better one.
#[derive(Clone, Copy, Debug)]
pub struct FibonacciLattice {
    lattice: Lattice,
}

impl FibonacciLattice {
    /// Returns the lattice of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        let g = generator(count::checked(n_points)?);
        Ok(Self { lattice: Lattice::rank_1(n_points, g as usize)? })
    }

    /// Returns the lattice.
    #[must_use]
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }
}

impl SquareSampler for FibonacciLattice {
    fn n_points(&self) -> usize {
        self.lattice.n_points()
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Lattice(self.lattice)
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        set.start().extend((0..self.n_points()).map(|j| self.lattice.point(j)));
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
            low_degrees: "0",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Zaremba 1966",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(FibonacciLattice::new(n_points)?))
    }
}

/// The number of generators that are compared.
const CANDIDATES: usize = 64;

/// Returns the generator of the lattice of `n` points.
fn generator(n: u32) -> u32 {
    let golden = f64::from(n) / f64::midpoint(1.0, 5_f64.sqrt());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
    let nearest = golden.round() as u32;
    let offset = |g: u32| (f64::from(g) - golden).abs();
    let around = (0..n).flat_map(|d| [nearest.checked_sub(d), nearest.checked_add(d)]);
    let coprime = around.flatten().filter(|&g| 0 < g && g < n && gcd(n, g) == 1);
    // The offset 0 occurs twice; a copy changes no maximum.
    let candidates = coprime.take(CANDIDATES + 1);
    let better = |a: &u32, b: &u32| {
        zaremba_index(n, *a).cmp(&zaremba_index(n, *b)).then(offset(*b).total_cmp(&offset(*a)))
    };
    candidates.max_by(better).unwrap_or(0)
}

/// Returns the smallest product `max(1, |h1|) max(1, |h2|)` over nonzero h with `h1 + g h2 = 0` modulo
/// n, for coprime g and n.
///
/// It is taken on at the denominator q of a convergent of g/n, with `h2 = q` and `|h1|` the
/// remainder of Euclid's algorithm there.
fn zaremba_index(n: u32, g: u32) -> u64 {
    let (mut before, mut remainder) = (u64::from(n), u64::from(g));
    let (mut q_before, mut q) = (0, 1);
    let mut index = u64::from(n);
    while remainder > 0 {
        index = index.min(q * remainder);
        let quotient = before / remainder;
        (before, remainder) = (remainder, before % remainder);
        (q_before, q) = (q, quotient * q + q_before);
    }
    index
}

#[cfg(test)]
mod tests {
    use super::{gcd, generator, zaremba_index};

    #[test]
    fn the_index_is_the_smallest_product_of_all_dual_frequencies() {
        for n in 1..90_u32 {
            for g in (1..n.max(2)).filter(|&g| gcd(n, g) == 1) {
                let at = |h2: u32| {
                    let h1 = u64::from(h2) * u64::from(g) % u64::from(n);
                    let h1 = h1.min(u64::from(n) - h1);
                    if h2 == 0 { u64::from(n) } else { h1.max(1) * u64::from(h2) }
                };
                let definition = (0..=n).map(at).min().unwrap();
                assert_eq!(zaremba_index(n, g), definition, "{g}/{n}");
            }
        }
    }

    #[test]
    fn fibonacci_numbers_have_fibonacci_generators() {
        let (mut before, mut n) = (1_u32, 2_u32);
        while n < 1 << 31 {
            assert_eq!(generator(n), before, "N = {n}");
            (before, n) = (n, before + n);
        }
    }

    #[test]
    fn generators_are_good_for_every_number() {
        assert_eq!((generator(1), generator(2), generator(3)), (0, 1, 2));
        for n in (2..3000).chain([65_536, 1_000_000, 1 << 31, u32::MAX]) {
            let g = generator(n);
            assert_eq!(gcd(n, g), 1, "N = {n}");
            assert!(6 * zaremba_index(n, g) >= u64::from(n), "N = {n}: {g}");
        }
    }
}
