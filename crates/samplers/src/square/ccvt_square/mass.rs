use rand::Rng;
use sphvar_grammar::Choice;

use crate::{Error, FibonacciLattice, PointSet, SquareSampler, WhiteSquare, shift, uniform_shift};

/// The kind of mass points of a tessellation of the square; it determines the spectrum at low
/// frequencies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SquareMassPoints {
    /// Independent uniform points, different in every realization. Their white noise remains:
    /// `P(k) -> 1/capacity` as |k| -> 0.
    White,
    /// The Fibonacci lattice of that number of points, shifted uniformly for every realization.
    Lattice,
}

impl Choice for SquareMassPoints {
    const CHOICES: &'static [(&'static str, Self)] =
        &[(Self::White.name(), Self::White), (Self::Lattice.name(), Self::Lattice)];
}

impl SquareMassPoints {
    /// Returns the name of the kind: `white` or `lattice`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Lattice => "lattice",
        }
    }

    /// Replaces `mass` by `count` mass points.
    pub(super) fn draw_into(
        self,
        count: usize,
        rng: &mut dyn Rng,
        mass: &mut PointSet<[f64; 2]>,
    ) -> Result<(), Error> {
        match self {
            Self::White => WhiteSquare::new(count)?.sample_into(rng, mass),
            Self::Lattice => {
                FibonacciLattice::new(count)?.sample_into(rng, mass)?;
                shift(uniform_shift(rng), &mut mass.points);
                Ok(())
            }
        }
    }
}
