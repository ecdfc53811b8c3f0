use std::fmt::Debug;

use rand::Rng;

use crate::Error;

/// A pattern of points of the unit square, to be mapped to directions by
/// [`OnSphere`](crate::OnSphere) or [`CosineHemisphere`](crate::CosineHemisphere).
///
/// As for a [`Sampler`](crate::Sampler), a realization is a function of the generator's state
/// alone. If the pattern is random, a point drawn at random from the set is uniform in the square,
/// so means over the points are unbiased; each implementor documents how.
pub trait SquarePattern: Debug + Send + Sync {
    /// Returns the number of points of every realization, at least 1.
    fn n_points(&self) -> usize;

    /// Returns whether two realizations can differ.
    fn is_random(&self) -> bool;

    /// Replaces the content of `points` by one realization: pairs `[u, v]` in [0, 1).
    ///
    /// # Errors
    ///
    /// [`Error::Infeasible`] if this realization cannot be completed; no pattern of this crate
    /// returns it.
    fn fill_into(&self, rng: &mut dyn Rng, points: &mut Vec<[f64; 2]>) -> Result<(), Error>;

    /// Returns one realization.
    ///
    /// # Errors
    ///
    /// Those of [`Self::fill_into`].
    fn fill(&self, rng: &mut dyn Rng) -> Result<Vec<[f64; 2]>, Error> {
        let mut points = Vec::with_capacity(self.n_points());
        self.fill_into(rng, &mut points)?;
        Ok(points)
    }
}

impl<P: SquarePattern + ?Sized> SquarePattern for Box<P> {
    fn n_points(&self) -> usize {
        (**self).n_points()
    }

    fn is_random(&self) -> bool {
        (**self).is_random()
    }

    fn fill_into(&self, rng: &mut dyn Rng, points: &mut Vec<[f64; 2]>) -> Result<(), Error> {
        (**self).fill_into(rng, points)
    }
}
