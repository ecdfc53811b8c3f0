use num_complex::Complex;
use sphvar_sh::{ByAxis, Frequencies, GaussLegendre, legendre_p_into};

use super::energy::{centre, check_values, energy_of_coefficients, zeros};
use super::spherical_bessel::spherical_bessel;
use crate::{Energy, Error, quadrature};

/// A function on the square as a sum of products of shifted Legendre polynomials,
/// `sum_mn a_mn P_m(2u - 1) P_n(2v - 1)`.
#[derive(Clone, Debug)]
pub(super) struct LegendreExpansion {
    /// The number of orders of each coordinate.
    len: usize,
    mean: f64,
    /// The coefficients `a_mn` at `m len + n`, without that of the mean.
    coefficients: Vec<f64>,
}

/// The values of a function at the nodes of a product rule.
pub(super) struct RuleValues {
    rule: GaussLegendre,
    mean: f64,
    /// At every node of u those of all nodes of v, without the mean.
    values: Vec<f64>,
}

/// Returns the Gauss-Legendre nodes of [0, 1].
fn nodes(rule: &GaussLegendre) -> Vec<f64> {
    rule.nodes().iter().map(|x| 0.5 + 0.5 * x).collect()
}

impl RuleValues {
    /// Returns the values at the `len^2` nodes of the Gauss-Legendre product rule.
    pub(super) fn new(
        len: usize,
        values_into: impl Fn(&[[f64; 2]], &mut [f64]) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        let rule = GaussLegendre::new(len)?;
        let places = nodes(&rule);
        let points = places.iter().flat_map(|&u| places.iter().map(move |&v| [u, v]));
        let mut values = zeros(len * len)?;
        values_into(&points.collect::<Vec<_>>(), &mut values)?;
        check_values(&values)?;
        let weights = rule.weights();
        let row_mean =
            |row: &[f64]| -> f64 { row.iter().zip(weights).map(|(x, w)| 0.5 * w * x).sum() };
        let mean = centre(&mut values, |values| {
            let rows = values.chunks_exact(len).zip(weights);
            rows.map(|(row, w)| 0.5 * w * row_mean(row)).sum()
        });
        Ok(Self { rule, mean, values })
    }

    /// Returns the kurtosis of the values.
    pub(super) fn kurtosis(&self) -> Option<f64> {
        let weights = self.rule.weights();
        quadrature::weighted_kurtosis(|| {
            let rows = self.values.chunks_exact(weights.len()).zip(weights);
            rows.flat_map(|(row, w)| row.iter().zip(weights).map(move |(x, along)| (w * along, *x)))
        })
    }

    /// Returns the polynomial with these values, whose degrees are below the number of nodes.
    pub(super) fn expansion(self) -> Result<LegendreExpansion, Error> {
        let weights = self.rule.weights();
        let len = weights.len();
        // Polynomials with the weights and norms of the transform, node by node.
        let mut factors = zeros(len * len)?;
        let transformed = self.rule.nodes().iter().zip(weights).zip(factors.chunks_exact_mut(len));
        for ((x, w), factors) in transformed {
            legendre_p_into(*x, factors)?;
            for (n, p) in factors.iter_mut().enumerate() {
                *p *= 0.5 * w * (2 * n + 1) as f64;
            }
        }
        // Along u, then along v.
        let along_u = product(&self.values, &factors, len)?;
        let mut coefficients = product(&along_u, &factors, len)?;
        coefficients[0] = 0.0;
        Ok(LegendreExpansion { len, mean: self.mean, coefficients })
    }
}

/// Returns the sums `sum_i a_ij b_im` at `j len + m`: the transform of the first index, which becomes
/// the last.
fn product(a: &[f64], b: &[f64], len: usize) -> Result<Vec<f64>, Error> {
    let mut sums = zeros(len * len)?;
    for (a, b) in a.chunks_exact(len).zip(b.chunks_exact(len)) {
        for (a, sums) in a.iter().zip(sums.chunks_exact_mut(len)) {
            sums.iter_mut().zip(b).for_each(|(sum, b)| *sum += a * b);
        }
    }
    Ok(sums)
}

impl LegendreExpansion {
    /// Returns the number of orders of each coordinate, which is that of nodes along a side.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Returns the integral over the square.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    /// Returns the coefficients `a_mn` for n = 0, 1, ... of an order m of u.
    fn of_order(&self, m: usize) -> &[f64] {
        &self.coefficients[m * self.len..(m + 1) * self.len]
    }

    /// Returns the variances of the three parts of the function.
    pub(super) fn variances(&self) -> ByAxis {
        let mut sums = ByAxis::default();
        for m in 0..self.len {
            for (n, a) in self.of_order(m).iter().enumerate() {
                let square = a * a / ((2 * m + 1) * (2 * n + 1)) as f64;
                match (m, n) {
                    (_, 0) => sums.u += square,
                    (0, _) => sums.v += square,
                    _ => sums.off += square,
                }
            }
        }
        sums
    }

    /// Returns the sum over all coefficients of the differences of energies to those of a polynomial
    /// with fewer.
    pub(super) fn distance(&self, coarse: &Self) -> f64 {
        let mut sum = 0.0;
        for m in 0..self.len {
            let other = if m < coarse.len { coarse.of_order(m) } else { &[] };
            for (n, a) in self.of_order(m).iter().enumerate() {
                let b = other.get(n).copied().unwrap_or_default();
                sum += (a * a - b * b).abs() / ((2 * m + 1) * (2 * n + 1)) as f64;
            }
        }
        sum
    }

    /// Returns the energies, from the transforms `(-i)^n j_n(pi k)` of the polynomials.
    pub(super) fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let len = self.len;
        let kmax = frequencies.kmax();
        let of_u: Vec<f64> = (0..len).map(|m| self.of_order(m)[0]).collect();
        let of_v = self.of_order(0);
        let mut waves = zeros::<Complex<f64>>((kmax + 1) * len)?;
        let mut rows = zeros::<Complex<f64>>((kmax + 1) * len)?;
        let (mut along_u, mut along_v) =
            (zeros(frequencies.axis_max() + 1)?, zeros(frequencies.axis_max() + 1)?);
        let (mut bessel, mut wave) = (vec![0.0; len.max(2)], vec![Complex::ZERO; len]);
        for k in 1..=frequencies.axis_max() {
            spherical_bessel(0.5 * k as f64, &mut bessel);
            for (n, (wave, j)) in wave.iter_mut().zip(&bessel).enumerate() {
                *wave = [Complex::ONE, -Complex::I, -Complex::ONE, Complex::I][n % 4] * *j;
            }
            let sum = |a: &[f64]| wave.iter().zip(a).map(|(w, a)| w * a).sum::<Complex<f64>>();
            along_u[k] = sum(&of_u).norm_sqr();
            along_v[k] = sum(of_v).norm_sqr();
            if k <= kmax {
                waves[k * len..(k + 1) * len].copy_from_slice(&wave);
                let row = &mut rows[k * len..(k + 1) * len];
                for (m, wave) in wave.iter().enumerate().skip(1) {
                    let with_order = row.iter_mut().zip(self.of_order(m)).skip(1);
                    with_order.for_each(|(sum, a)| *sum += wave * a);
                }
            }
        }
        energy_of_coefficients(frequencies, self.mean, self.variances(), |[k1, k2]| {
            let [i, j] = [k1, k2].map(|k| k.unsigned_abs() as usize);
            if j == 0 {
                return along_u[i];
            }
            if i == 0 {
                return along_v[j];
            }
            let (row, wave) = (&rows[i * len..(i + 1) * len], &waves[j * len..(j + 1) * len]);
            let pairs = row.iter().zip(wave);
            let sum: Complex<f64> = match k1 < 0 {
                true => pairs.map(|(row, wave)| row.conj() * wave).sum(),
                false => pairs.map(|(row, wave)| row * wave).sum(),
            };
            sum.norm_sqr()
        })
    }
}
