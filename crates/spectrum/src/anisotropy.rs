use num_complex::Complex;
use sphvar_sh::LmIndex;

use crate::{Accumulator, Error, Moments, Realization};

/// Accumulates what a homogeneous ensemble has none of: differences between the orders of a degree,
/// and products of different coefficients.
///
/// For every (l, m) the power of the order less the power of its degree, realization by realization:
/// the mean is 0 for a homogeneous ensemble, and its standard error knows how the orders of one
/// realization vary together.
#[derive(Clone, Debug)]
pub struct Anisotropy {
    index: LmIndex,
    orders: Vec<Moments>,
    pairs: Vec<[(usize, usize); 2]>,
    products: Vec<[Moments; 4]>,
}

impl Anisotropy {
    /// An empty accumulator for degrees up to `lmax` and the products of these pairs of (l, m),
    /// m >= 0: some 300 bytes for an order and 1200 for a pair.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if `lmax` is beyond what the index can hold.
    ///
    /// # Panics
    ///
    /// If a pair has a degree above `lmax` or an order above its degree.
    pub fn new(lmax: usize, pairs: &[[(usize, usize); 2]]) -> Result<Self, Error> {
        for (l, m) in pairs.iter().flatten() {
            assert!(m <= l && *l <= lmax, "({l}, {m}) is not among the degrees up to {lmax}");
        }
        let index = LmIndex::new(lmax)?;
        Ok(Self {
            index,
            orders: vec![Moments::default(); index.len()],
            pairs: pairs.to_vec(),
            products: vec![Default::default(); pairs.len()],
        })
    }

    /// `(4 pi/N) |S_lm|^2 - P(l)` of every (l, m), in the order of the index.
    pub fn orders(&self) -> impl Iterator<Item = ((usize, usize), &Moments)> {
        self.index.iter().zip(&self.orders)
    }

    /// The same of one (l, m).
    ///
    /// # Panics
    ///
    /// If `m > l` or `l` is above the largest degree.
    #[must_use]
    pub fn order(&self, l: usize, m: usize) -> &Moments {
        &self.orders[self.index.at(l, m)]
    }

    /// For every pair the real and imaginary part of `(4 pi/N) S_lm conj S_l'm'`, then those of
    /// `(4 pi/N) S_lm S_l'm'`.
    pub fn products(&self) -> impl Iterator<Item = ([(usize, usize); 2], &[Moments; 4])> {
        self.pairs.iter().copied().zip(&self.products)
    }
}

impl Accumulator for Anisotropy {
    fn push(&mut self, realization: &Realization<'_>) {
        let (alm, scale) = (realization.alm(), realization.normalization());
        let degree: Vec<f64> = realization.power().collect();
        for ((l, _), (moments, a)) in
            alm.index().iter().zip(self.orders.iter_mut().zip(alm.values()))
        {
            moments.push(scale * a.norm_sqr() - degree[l]);
        }
        for (&[a, b], moments) in self.pairs.iter().zip(&mut self.products) {
            let (a, b): (Complex<f64>, Complex<f64>) = (alm[a], alm[b]);
            let (covariance, plain) = (scale * a * b.conj(), scale * a * b);
            let parts = [covariance.re, covariance.im, plain.re, plain.im];
            for (m, x) in moments.iter_mut().zip(parts) {
                m.push(x);
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        for (a, b) in self.orders.iter_mut().zip(&other.orders) {
            a.merge(b);
        }
        for (a, b) in self.products.iter_mut().flatten().zip(other.products.iter().flatten()) {
            a.merge(b);
        }
    }
}
