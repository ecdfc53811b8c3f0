use std::fmt::Debug;

use glam::DVec3;
use rand::Rng;

use crate::{Domain, Error};

/// A pattern of directions of a fixed number of points: what it takes to make one realization.
///
/// A sampler is immutable; all randomness comes from the generator that is passed in, so that a
/// realization is a function of the generator's state alone. A realization need not be
/// homogeneous by itself: whoever relies on the law being invariant under rotations turns it by
/// [`uniform_rotation`](crate::uniform_rotation), as [`Realizations`](crate::Realizations) does.
///
/// The trait is object-safe: tools keep lists of `Box<dyn Sampler>`.
pub trait Sampler: Debug + Send + Sync {
    /// The number of points of every realization, at least 1.
    fn n_points(&self) -> usize;

    /// Where the points live.
    fn domain(&self) -> Domain;

    /// Whether two realizations can differ by more than a rotation. `false` means that one
    /// realization holds the whole spectrum of the pattern.
    fn is_random(&self) -> bool;

    /// Whether the points of a realization are independent of each other and uniformly distributed, so that moments
    /// of estimates follow from those of the integrand. `false` where that is not known.
    fn is_independent(&self) -> bool {
        self.n_points() == 1
    }

    /// Returns the last degree t such that no realization has power at any degree `1 <= l <= t` of the
    /// domain (0 if there is none), for patterns that are made so; `None` for others.
    fn last_empty_degree(&self) -> Option<usize> {
        None
    }

    /// Replaces the content of `points` by one realization: `n_points` unit vectors, with z >= 0
    /// on the hemisphere.
    ///
    /// The buffer is taken whole rather than as a slice so that a loop over realizations
    /// allocates once and patterns with a random number of points fit the same contract.
    ///
    /// # Errors
    ///
    /// [`Error::Infeasible`] if this realization cannot be completed; most patterns have none.
    fn sample_into(&self, rng: &mut dyn Rng, points: &mut Vec<DVec3>) -> Result<(), Error>;

    /// One realization in a vector of its own.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`].
    fn sample(&self, rng: &mut dyn Rng) -> Result<Vec<DVec3>, Error> {
        let mut points = Vec::with_capacity(self.n_points());
        self.sample_into(rng, &mut points)?;
        Ok(points)
    }
}
