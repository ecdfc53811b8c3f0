use rand::{Rng, RngExt};

use crate::{Error, SquarePattern, count};

/// Independent uniform points of the square.
#[derive(Clone, Copy, Debug)]
pub struct WhiteSquare {
    n: u32,
}

impl WhiteSquare {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquarePattern for WhiteSquare {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn is_random(&self) -> bool {
        true
    }

    fn fill_into(&self, rng: &mut dyn Rng, points: &mut Vec<[f64; 2]>) -> Result<(), Error> {
        points.clear();
        points.extend((0..self.n).map(|_| rng.random::<[f64; 2]>()));
        Ok(())
    }
}
