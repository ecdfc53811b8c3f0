use num_complex::Complex;
use sphvar_sh::Alm;

use crate::{Accumulator, Realization};

/// Collects one coefficient `S_lm` of every realization, for example to study its distribution.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoefficientSamples {
    l: usize,
    m: usize,
    samples: Vec<(u64, Complex<f64>)>,
}

impl CoefficientSamples {
    /// Returns an empty collection for degree `l` and order `m`, 0 <= m <= l.
    #[must_use]
    pub fn new(l: usize, m: usize) -> Self {
        Self { l, m, samples: Vec::new() }
    }

    /// Adds the coefficient of the realization of this index.
    ///
    /// # Panics
    ///
    /// Panics if the coefficients do not reach degree l.
    pub fn push_alm(&mut self, index: u64, alm: &Alm) {
        let value = alm.values()[alm.index().at(self.l, self.m)];
        self.samples.push((index, value));
    }

    /// Returns the coefficients in the order of the realizations.
    #[must_use]
    pub fn finish(mut self) -> Vec<Complex<f64>> {
        self.samples.sort_by_key(|s| s.0);
        self.samples.into_iter().map(|s| s.1).collect()
    }
}

impl Accumulator for CoefficientSamples {
    fn push(&mut self, realization: &Realization<'_>) {
        self.push_alm(realization.index(), realization.alm());
    }

    fn merge(&mut self, other: &Self) {
        self.samples.extend_from_slice(&other.samples);
    }
}
