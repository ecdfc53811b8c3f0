use num_complex::Complex;
use sphvar_sh::{ByAxis, Frequencies};

use super::energy::energy_of_coefficients;
use super::panel_series::PanelSeries;
use crate::{Energy, Error, quadrature};

/// A sum of products of functions of one coordinate, `sum_r a_r(u) b_r(v)`.
#[derive(Clone, Debug)]
pub(super) struct Separable {
    u: PanelSeries,
    v: PanelSeries,
}

impl Separable {
    /// Returns the sum of products of the functions `u` and as many functions `v`.
    pub(super) fn new(u: PanelSeries, v: PanelSeries) -> Self {
        Self { u, v }
    }

    /// Returns the integral over the square.
    pub(super) fn mean(&self) -> f64 {
        self.u.means().iter().zip(self.v.means()).map(|(a, b)| a * b).sum()
    }

    /// Returns the kurtosis of the value at a uniformly distributed point, from some two thousand
    /// values of each coordinate.
    pub(super) fn kurtosis(&self) -> Option<f64> {
        let nodes =
            |series: &PanelSeries| series.values((2000 / series.n_panels()).clamp(4, 24)).ok();
        let (along_u, along_v) = (nodes(&self.u)?, nodes(&self.v)?);
        let (of_u, of_v) = (self.u.means(), self.v.means());
        // The value without the mean, of which no part cancels.
        let value = |a: &[f64], b: &[f64]| -> f64 {
            let means = of_u.iter().zip(of_v);
            let terms = a.iter().zip(b).zip(means);
            terms.map(|((a, b), (of_a, of_b))| a * of_b + of_a * b + a * b).sum()
        };
        quadrature::weighted_kurtosis(|| {
            along_u.iter().flat_map(|(weight, a)| {
                along_v.iter().map(move |(other, b)| (weight * other, value(a, b)))
            })
        })
    }

    /// Returns the energies.
    ///
    /// The part that depends on u alone is `sum_r mean(b_r) (a_r - mean(a_r))`, and the part off the
    /// axes has the variance `sum_rs cov(a_r, a_s) cov(b_r, b_s)`.
    pub(super) fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let along_u = self.u.combined(self.v.means());
        let along_v = self.v.combined(self.u.means());
        let ranks = 0..self.u.means().len();
        let products = ranks.clone().flat_map(|r| ranks.clone().map(move |s| (r, s)));
        let off: f64 =
            products.map(|(r, s)| self.u.covariance(r, s) * self.v.covariance(r, s)).sum();
        let (u, v) = (along_u.covariance(0, 0), along_v.covariance(0, 0));
        let centred = ByAxis { off: off.max(0.0), u, v };
        let axis = |series: &PanelSeries| -> Result<Vec<f64>, Error> {
            let coefficients = series.coefficients(frequencies.axis_max())?;
            Ok(coefficients[0].iter().map(Complex::norm_sqr).collect())
        };
        let different = if along_v == along_u { None } else { Some(axis(&along_v)?) };
        let along_u = axis(&along_u)?;
        let along_v = different.as_ref().unwrap_or(&along_u);
        let kmax = frequencies.kmax();
        let (of_u, of_v) = (self.u.coefficients(kmax)?, self.v.coefficients(kmax)?);
        energy_of_coefficients(frequencies, self.mean(), centred, |[k1, k2]| {
            let [i, j] = [k1, k2].map(|k| k.unsigned_abs() as usize);
            if j == 0 {
                return along_u[i];
            }
            if i == 0 {
                return along_v[j];
            }
            // Frequencies have k2 > 0 off the axes; coefficients of real functions at -k are the
            // conjugates of those at k.
            let terms = of_u.iter().zip(&of_v).map(|(a, b)| {
                let a = if k1 < 0 { a[i].conj() } else { a[i] };
                a * b[j]
            });
            terms.sum::<Complex<f64>>().norm_sqr()
        })
    }
}
