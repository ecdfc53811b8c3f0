use sphvar_grammar::{Declaration, Parametric};

use crate::definition::{Definition, FileResolver};
use crate::patterns::point_file::{FACTS, unread};
use crate::{Error, PatternFacts, PointFileParameters, Square, SquareSampler, ValidCounts};

/// Parameters of the pattern `file` of the square: point sets from a file, one of which is drawn
/// uniformly.
pub type SquarePointFileParameters = PointFileParameters<Square>;

impl Parametric for SquarePointFileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        self.declare_table(d, "take coordinates modulo 1");
    }
}

impl Definition<Square> for SquarePointFileParameters {
    fn facts(&self) -> PatternFacts {
        FACTS
    }

    fn valid_counts(&self, _: Square) -> ValidCounts {
        self.counts()
    }

    fn stream_group(&self, n_points: usize) -> Option<usize> {
        self.content().ok()?.stream_group(n_points)
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        let sets = self.content()?.square_sets(n_points);
        Ok(Box::new(sets.ok_or_else(unread)?))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        self.read(Square, |source| files.square_points(source))
    }
}
