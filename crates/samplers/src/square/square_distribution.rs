use crate::{Lattice, PointSet};

/// The known properties of the distribution of the realizations of a
/// [`SquareSampler`](crate::SquareSampler), up to shifts modulo 1. They decide whether spectra are
/// computed in closed form or estimated.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SquareDistribution<'a> {
    /// No property that determines a spectrum.
    Random,
    /// Independent uniform points.
    Independent,
    /// One uniform point in each rectangle of a grid, independent of the others:
    /// `P(k) = 1 - sinc^2(k1/rows) sinc^2(k2/columns)` with `sinc x = sin(pi x)/(pi x)`.
    Jittered {
        /// The number of strips in u.
        rows: usize,
        /// The number of parts in v of each strip.
        columns: usize,
    },
    /// One uniform point in each of N strips of both coordinates, in a uniform random order; see
    /// [`LatinHypercube`](crate::LatinHypercube) for its power.
    LatinHypercube,
    /// Always the same set: one realization determines the spectrum of the pattern.
    Fixed,
    /// Always the same lattice, shifted by a constant: `P(k) = N` at the frequencies of its dual
    /// lattice, 0 elsewhere.
    Lattice(Lattice),
    /// One of the given sets, drawn uniformly.
    OneOf(&'a [PointSet<[f64; 2]>]),
}

impl SquareDistribution<'_> {
    /// Returns whether two realizations can differ by more than a shift.
    #[must_use]
    pub fn is_random(&self) -> bool {
        match self {
            Self::Fixed | Self::Lattice(_) => false,
            Self::OneOf(sets) => sets.len() > 1,
            Self::Random | Self::Independent | Self::Jittered { .. } | Self::LatinHypercube => true,
        }
    }
}
