use sphvar_sh::{Alm, LmIndex};

use crate::{Accumulator, Error, Moments, Realization};

/// Accumulates the power of every order: `(4 pi / N) |S_lm|^2` for each (l, m), m >= 0.
///
/// For a homogeneous ensemble the mean is P(l) for every m; differences between orders reveal
/// anisotropy.
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
    /// Returns an empty accumulator for degrees up to `lmax`. It uses about 300 bytes for each of
    /// the (lmax+1)(lmax+2)/2 orders.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if `lmax` exceeds the limit of the index.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        let index = LmIndex::new(lmax)?;
        Ok(Self { index, orders: vec![Moments::default(); index.len()] })
    }

    /// Returns the maximum degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Returns the number of realizations common to all orders; 0 if the number of orders does not
    /// match `lmax`, which is possible only for deserialized accumulators.
    #[must_use]
    pub fn realizations(&self) -> u64 {
        let counts = self.orders.iter().map(Moments::count);
        if self.orders.len() == self.index.len() { counts.min().unwrap_or(0) } else { 0 }
    }

    /// Adds the coefficients of one realization, whose squares are multiplied by `normalization`.
    pub fn push_alm(&mut self, alm: &Alm, normalization: f64) {
        for (moments, a) in self.orders.iter_mut().zip(alm.values()) {
            moments.push(normalization * a.norm_sqr());
        }
    }

    /// Returns the mean power of every (l, m), sorted by degree and then by order.
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
        self.push_alm(realization.alm(), realization.normalization());
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.orders.iter_mut().zip(&other.orders) {
            mine.merge(theirs);
        }
    }
}
