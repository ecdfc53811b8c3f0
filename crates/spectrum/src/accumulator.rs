use crate::Realization;

/// Accumulates statistics of the coefficients of an ensemble.
///
/// `merge` must give the same bits as pushing the other's realizations would, whatever the order:
/// that is what makes results independent of threads.
pub trait Accumulator: Clone + Send + Sync {
    /// Takes one realization in.
    fn push(&mut self, realization: &Realization<'_>);
    /// Takes in everything that `other`, a copy of the same empty accumulator, has seen.
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
