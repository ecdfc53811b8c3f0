use std::marker::PhantomData;

use sphvar_grammar::{Declaration, Parametric};

use super::scrambling::Scrambling;
use crate::definition::Definition;
use crate::{Error, PatternFacts, Square, SquareSampler};

/// A pattern of the square that is defined by the digits of its coordinates.
pub trait ScrambledPattern: SquareSampler + Sized + 'static {
    /// The scrambling of the pattern of the square unless another is requested.
    const SCRAMBLING: Scrambling;

    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    fn scrambled(n_points: usize, scrambling: Scrambling) -> Result<Self, Error>;

    /// Returns the known properties of the pattern, whose sets may be shifted in addition.
    fn facts(scrambling: Scrambling) -> PatternFacts;
}

/// Parameters of a [`ScrambledPattern`] of the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScrambledParameters<P> {
    /// The randomization of the digits.
    pub randomization: Scrambling,
    pattern: PhantomData<P>,
}

impl<P: ScrambledPattern> ScrambledParameters<P> {
    /// The default parameters.
    pub const DEFAULT: Self = Self::new(P::SCRAMBLING);

    /// Returns the parameters with a randomization of the digits.
    #[must_use]
    pub const fn new(randomization: Scrambling) -> Self {
        Self { randomization, pattern: PhantomData }
    }
}

impl<P: ScrambledPattern> Default for ScrambledParameters<P> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl<P: ScrambledPattern> Parametric for ScrambledParameters<P> {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "randomization of the digits, before any shift";
        d.choice("randomization", summary, &mut self.randomization);
    }
}

impl<P: ScrambledPattern> Definition<Square> for ScrambledParameters<P> {
    fn facts(&self) -> PatternFacts {
        P::facts(self.randomization)
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(P::scrambled(n_points, self.randomization)?))
    }
}
