use std::fmt::{Debug, Display};

use crate::{Domain, Error, Pattern, Sampler};

/// A pattern at any number of points, for variance curves and rankings; its `Display` text is the
/// pattern's name.
///
/// [`Pattern`] implements it for the patterns of this crate, [`FnPattern`](crate::FnPattern) for
/// functions; implement it to compare your own patterns with them.
pub trait SamplerFamily: Debug + Display + Send + Sync {
    /// Returns the sampler of exactly `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error`] if the number is not valid; user-defined patterns return [`Error::Infeasible`].
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error>;

    /// Returns the valid number of points nearest to `requested`, at least 1 and nondecreasing in
    /// `requested`. Default: every number is valid.
    fn nearest_count(&self, requested: usize, _domain: Domain) -> usize {
        requested.max(1)
    }
}

impl<F: SamplerFamily + ?Sized> SamplerFamily for &F {
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        (**self).build(n_points, domain)
    }

    fn nearest_count(&self, requested: usize, domain: Domain) -> usize {
        (**self).nearest_count(requested, domain)
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
