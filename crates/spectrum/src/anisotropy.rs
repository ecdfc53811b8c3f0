use num_complex::Complex;
use sphvar_sh::LmIndex;

use crate::{Accumulator, Error, Moments, Realization};

/// Accumulates differences between the orders of a degree and products of different coefficients,
/// both of mean zero for a homogeneous ensemble.
///
/// For every (l, m) the accumulated number is the power of the order minus the power of its degree
/// in the same realization. Its standard error therefore accounts for the correlation between the
/// orders of one realization.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Loaded")
)]
pub struct Anisotropy {
    index: LmIndex,
    orders: Vec<Moments>,
    pairs: Vec<[(usize, usize); 2]>,
    products: Vec<[Moments; 4]>,
}

/// Deserialized fields of an [`Anisotropy`] before validation.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Loaded {
    index: LmIndex,
    orders: Vec<Moments>,
    pairs: Vec<[(usize, usize); 2]>,
    products: Vec<[Moments; 4]>,
}

#[cfg(feature = "serde")]
impl TryFrom<Loaded> for Anisotropy {
    type Error = &'static str;

    fn try_from(loaded: Loaded) -> Result<Self, Self::Error> {
        let Loaded { index, orders, pairs, products } = loaded;
        let lmax = index.lmax();
        let is_index = LmIndex::new(lmax).is_ok_and(|index| orders.len() == index.len());
        let are_pairs = pairs.iter().flatten().all(|(l, m)| m <= l && *l <= lmax);
        if is_index && are_pairs && products.len() == pairs.len() {
            Ok(Self { index, orders, pairs, products })
        } else {
            Err("invalid numbers of orders or products")
        }
    }
}

impl Anisotropy {
    /// Returns an empty accumulator for degrees up to `lmax` and for products of the given pairs of
    /// (l, m), m >= 0. It uses about 300 bytes per order and 1200 per pair.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if `lmax` exceeds the limit of the index.
    ///
    /// # Panics
    ///
    /// Panics if a pair has a degree above `lmax` or an order above its degree.
    pub fn new(lmax: usize, pairs: &[[(usize, usize); 2]]) -> Result<Self, Error> {
        for (l, m) in pairs.iter().flatten() {
            assert!(
                m <= l && *l <= lmax,
                "({l}, {m}) is not a valid (degree, order) for lmax {lmax}"
            );
        }
        let index = LmIndex::new(lmax)?;
        Ok(Self {
            index,
            orders: vec![Moments::default(); index.len()],
            pairs: pairs.to_vec(),
            products: vec![Default::default(); pairs.len()],
        })
    }

    /// Returns the maximum degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Returns the moments of `(4 pi/N) |S_lm|^2 - P(l)` for every (l, m), in index order.
    pub fn orders(&self) -> impl Iterator<Item = ((usize, usize), &Moments)> {
        self.index.iter().zip(&self.orders)
    }

    /// Returns the moments of `(4 pi/N) |S_lm|^2 - P(l)` for one (l, m).
    ///
    /// # Panics
    ///
    /// Panics if `m > l` or `l` is above the maximum degree.
    #[must_use]
    pub fn order(&self, l: usize, m: usize) -> &Moments {
        &self.orders[self.index.at(l, m)]
    }

    /// Returns, for every pair, the moments of the real and imaginary part of
    /// `(4 pi/N) S_lm conj S_l'm'`, followed by those of `(4 pi/N) S_lm S_l'm'`.
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
