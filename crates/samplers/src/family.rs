use std::fmt::{Debug, Display};

use crate::{Domain, Error, Pattern, Sampler, Space, Square, SquarePattern, SquareSampler};

/// A pattern at any number of points, for variance curves and rankings; its `Display` text is the
/// pattern's name.
///
/// [`Pattern`] and [`SquarePattern`] implement it for the patterns of this crate,
/// [`FnPattern`](crate::FnPattern) for functions; implement it to compare your own patterns with
/// them. `SamplerFamily` is a pattern of directions, `SamplerFamily<Square>` one of the square.
pub trait SamplerFamily<S: Space = Domain>: Debug + Display + Send + Sync {
    /// Returns the sampler of exactly `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error`] if the number is not valid; user-defined patterns return [`Error::Infeasible`].
    fn build(&self, n_points: usize, space: S) -> Result<Box<S::Sampler>, Error>;

    /// Returns the valid number of points nearest to `requested`, at least 1 and nondecreasing in
    /// `requested`. Default: every number is valid.
    fn nearest_count(&self, requested: usize, _space: S) -> usize {
        requested.max(1)
    }
}

impl<S: Space, F: SamplerFamily<S> + ?Sized> SamplerFamily<S> for &F {
    fn build(&self, n_points: usize, space: S) -> Result<Box<S::Sampler>, Error> {
        (**self).build(n_points, space)
    }

    fn nearest_count(&self, requested: usize, space: S) -> usize {
        (**self).nearest_count(requested, space)
    }
}

impl SamplerFamily for Pattern {
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Self::build(self, n_points, domain)
    }

    fn nearest_count(&self, requested: usize, domain: Domain) -> usize {
        Self::nearest_count(self, requested, domain)
    }
}

impl SamplerFamily<Square> for SquarePattern {
    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Self::build(self, n_points)
    }

    fn nearest_count(&self, requested: usize, _: Square) -> usize {
        Self::nearest_count(self, requested)
    }
}
