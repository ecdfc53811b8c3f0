use crate::Realization;

/// Accumulates statistics of spherical-harmonic coefficients over an ensemble.
///
/// `merge` must give a result bit-identical to pushing the realizations of `other`, in any order.
/// Results are then independent of the number of threads.
pub trait Accumulator: Clone + Send + Sync {
    /// Adds one realization.
    fn push(&mut self, realization: &Realization<'_>);
    /// Adds the realizations of `other`, which must start from a copy of the same empty
    /// accumulator.
    fn merge(&mut self, other: &Self);
}

impl<A: Accumulator, B: Accumulator> Accumulator for (A, B) {
    fn push(&mut self, realization: &Realization<'_>) {
        self.0.push(realization);
        self.1.push(realization);
    }

    fn merge(&mut self, other: &Self) {
        self.0.merge(&other.0);
        self.1.merge(&other.1);
    }
}

impl<A: Accumulator> Accumulator for Option<A> {
    fn push(&mut self, realization: &Realization<'_>) {
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

impl<A: Accumulator> Accumulator for Vec<A> {
    fn push(&mut self, realization: &Realization<'_>) {
        self.iter_mut().for_each(|inner| inner.push(realization));
    }

    fn merge(&mut self, other: &Self) {
        self.iter_mut().zip(other).for_each(|(mine, theirs)| mine.merge(theirs));
    }
}
