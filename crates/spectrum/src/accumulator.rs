use sphvar_sh::Domain;

use crate::{Realization, SpectralBands};

/// Accumulates statistics of the coefficients of point sets over an ensemble: of spherical
/// harmonics, or of other bands B.
///
/// `merge` must give a result bit-identical to pushing the realizations of `other`, in any order.
/// Results are then independent of the number of threads.
pub trait Accumulator<B: SpectralBands = Domain>: Clone + Send + Sync {
    /// Adds one realization.
    fn push(&mut self, realization: &Realization<'_, B>);
    /// Adds the realizations of `other`, which must start from a copy of the same empty
    /// accumulator.
    fn merge(&mut self, other: &Self);
}

impl<B: SpectralBands, X: Accumulator<B>, Y: Accumulator<B>> Accumulator<B> for (X, Y) {
    fn push(&mut self, realization: &Realization<'_, B>) {
        self.0.push(realization);
        self.1.push(realization);
    }

    fn merge(&mut self, other: &Self) {
        self.0.merge(&other.0);
        self.1.merge(&other.1);
    }
}

impl<B: SpectralBands, A: Accumulator<B>> Accumulator<B> for Option<A> {
    fn push(&mut self, realization: &Realization<'_, B>) {
        if let Some(inner) = self {
            inner.push(realization);
        }
    }

    fn merge(&mut self, other: &Self) {
        if let (Some(mine), Some(theirs)) = (self, other) {
            mine.merge(theirs);
        }
    }
}

impl<B: SpectralBands, A: Accumulator<B>> Accumulator<B> for Vec<A> {
    fn push(&mut self, realization: &Realization<'_, B>) {
        self.iter_mut().for_each(|inner| inner.push(realization));
    }

    fn merge(&mut self, other: &Self) {
        self.iter_mut().zip(other).for_each(|(mine, theirs)| mine.merge(theirs));
    }
}
