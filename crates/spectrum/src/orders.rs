use sphvar_sh::LmIndex;

use crate::{Accumulator, Error, Moments, Realization};

/// Accumulates the power of every order: `(4 pi / N) |S_lm|^2` for each (l, m), m >= 0.
///
/// Its mean over a homogeneous ensemble is P(l) for every m; differences between orders show
/// that an ensemble prefers directions.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OrderAccumulator {
    index: LmIndex,
    orders: Vec<Moments>,
}

/// The mean power of one (l, m) and the standard error of that mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderPower {
    /// The degree.
    pub l: usize,
    /// The order, from 0 to l.
    pub m: usize,
    /// The mean of `(4 pi / N) |S_lm|^2`.
    pub power: f64,
    /// The standard error of the mean, NaN for a single realization.
    pub stderr: f64,
}

impl OrderAccumulator {
    /// An empty accumulator for degrees up to `lmax`: some 300 bytes for each of the
    /// (lmax+1)(lmax+2)/2 orders.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if `lmax` is beyond what the index can hold.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        let index = LmIndex::new(lmax)?;
        Ok(Self { index, orders: vec![Moments::default(); index.len()] })
    }

    /// The last degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// The number of realizations that every order has seen; 0 if there are not as many orders as the degrees have, as only
    /// in one that was read can be.
    #[must_use]
    pub fn realizations(&self) -> u64 {
        let counts = self.orders.iter().map(Moments::count);
        if self.orders.len() == self.index.len() { counts.min().unwrap_or(0) } else { 0 }
    }

    /// The mean power of every (l, m), by degree and then by order.
    #[must_use]
    pub fn finish(&self) -> Vec<OrderPower> {
        let lm = (0..=self.index.lmax()).flat_map(|l| (0..=l).map(move |m| (l, m)));
        lm.map(|(l, m)| {
            let moments = &self.orders[self.index.at(l, m)];
            OrderPower { l, m, power: moments.mean(), stderr: moments.standard_error() }
        })
        .collect()
    }
}

impl Accumulator for OrderAccumulator {
    fn push(&mut self, realization: &Realization<'_>) {
        let normalization = realization.normalization();
        for (moments, a) in self.orders.iter_mut().zip(realization.alm().values()) {
            moments.push(normalization * a.norm_sqr());
        }
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.orders.iter_mut().zip(&other.orders) {
            mine.merge(theirs);
        }
    }
}
