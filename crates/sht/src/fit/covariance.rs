use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use num_complex::Complex;
use sphvar_sh::Alm;

use super::inverse::Inverse;
use super::noise::NoiseEnergy;
use crate::normal_equations::{SolveError, Watch};

/// The covariance C of the coefficients for noise of variance 1, from the dense matrix of the
/// normal equations.
///
/// Vectors have the components of real orthonormal harmonics, degree by degree: order 0, then
/// `sqrt(2) Re a_lm` and `sqrt(2) Im a_lm` for m = 1 to l.
#[derive(Clone, Debug)]
pub(super) struct Covariance {
    /// The block of each degree by rows; empty for degrees that the domain lacks.
    blocks: Vec<Vec<f64>>,
    /// `tr M^-2`.
    pub(super) square_trace: f64,
}

impl Covariance {
    /// Returns the covariance `M^-1 A M^-1`, or `None` if M is not positive definite up to rounding.
    ///
    /// For P harmonics it costs P products with M and `P^3/2` multiplications, three times as many
    /// with a ridge, and the memory of two matrices.
    pub(super) fn of(
        inverse: &mut Inverse<'_>,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, SolveError> {
        let (domain, lmax, ridge) = (inverse.domain(), inverse.lmax(), inverse.ridge());
        let matrix = Dense::of(inverse, watch)?;
        let n = matrix.n;
        let mut inverted = matrix.clone();
        (0..n).for_each(|i| inverted.row_mut(i)[i] += ridge);
        if !inverted.invert(watch)? {
            return Ok(None);
        }
        let mut blocks = Vec::with_capacity(lmax + 1);
        let mut first = 0;
        let mut row = vec![0.0; n];
        for l in 0..=lmax {
            let end = first + if domain.has_degree(l) { 2 * l + 1 } else { 0 };
            let mut block = Vec::with_capacity((end - first).pow(2));
            for i in first..end {
                if ridge == 0.0 {
                    block.extend_from_slice(&inverted.row(i)[first..end]);
                    continue;
                }
                if watch().is_break() {
                    return Err(SolveError::Stopped);
                }
                // M^-1 - ridge M^-2 would cancel for a large ridge.
                row.fill(0.0);
                for (k, factor) in inverted.row(i).iter().enumerate() {
                    add(&mut row, *factor, matrix.row(k));
                }
                let dot = |b: &[f64]| row.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                block.extend((first..end).map(|j| dot(inverted.row(j))));
            }
            blocks.push(block);
            first = end;
        }
        let square_trace = inverted.entries.iter().map(|x| x * x).sum();
        Ok(Some(Self { blocks, square_trace }))
    }

    /// Returns `tr_l C`.
    pub(super) fn trace(&self, l: usize) -> f64 {
        self.blocks[l].iter().step_by(2 * l + 2).sum()
    }

    /// Returns the energy of the noise of degree `l` in these fitted coefficients.
    ///
    /// For Gaussian noise `|F_l|^2` has the variance `4 s^2 f^T C f + 2 s^4 tr C^2` about the true
    /// coefficients f. `F^T C F - s^2 tr C^2` is unbiased for `f^T C f`, which is not negative.
    pub(super) fn noise(&self, l: usize, variance: f64, freedom: f64, fitted: &Alm) -> NoiseEnergy {
        // A degree that the domain lacks has no rows.
        let block = &self.blocks[l];
        let components: Vec<f64> = components(fitted, l).collect();
        let rows = block.chunks_exact(components.len());
        let image = |row: &[f64]| row.iter().zip(&components).map(|(c, f)| c * f).sum::<f64>();
        let form: f64 = rows.zip(&components).map(|(row, f)| f * image(row)).sum();
        let square: f64 = block.iter().map(|c| c * c).sum();
        let mean = variance * self.trace(l);
        let of_function = 4.0 * variance * (form - variance * square).max(0.0);
        let of_noise = 2.0 * variance * variance * square;
        let of_variance = 2.0 * mean * mean / freedom;
        NoiseEnergy { mean, stderr: (of_function + of_noise + of_variance).sqrt() }
    }
}

/// A square matrix by rows.
#[derive(Clone)]
struct Dense {
    n: usize,
    entries: Vec<f64>,
}

impl Dense {
    /// Returns A, from its products with unit vectors.
    fn of(inverse: &mut Inverse<'_>, watch: Watch<'_>) -> Result<Self, SolveError> {
        let (domain, lmax) = (inverse.domain(), inverse.lmax());
        let mut entries = Vec::new();
        let mut unit = Alm::zeros(lmax)?;
        let mut image = unit.clone();
        let degrees = || (0..=lmax).filter(|&l| domain.has_degree(l));
        let mut n = 0;
        for (l, m) in degrees().flat_map(|l| (0..=l).map(move |m| (l, m))) {
            let parts = if m == 0 { &UNITS[..1] } else { &UNITS[1..] };
            for part in parts {
                if watch().is_break() {
                    return Err(SolveError::Stopped);
                }
                unit[(l, m)] = *part;
                inverse.apply(&unit, &mut image);
                entries.extend(degrees().flat_map(|l| components(&image, l)));
                n += 1;
            }
            unit[(l, m)] = Complex::ZERO;
        }
        Ok(Self { n, entries })
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.n..][..self.n]
    }

    fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.entries[i * self.n..][..self.n]
    }

    /// Inverts a symmetric positive definite matrix by the symmetric sweep operator (Goodnight
    /// 1979, doi:10.1080/00031305.1979.10482685) without pivoting; returns false at a pivot that is
    /// not positive. Only the lower triangle is read.
    fn invert(&mut self, watch: Watch<'_>) -> Result<bool, SolveError> {
        let n = self.n;
        let mut column = vec![0.0; n];
        for k in 0..n {
            if watch().is_break() {
                return Err(SolveError::Stopped);
            }
            column[..k].copy_from_slice(&self.row(k)[..k]);
            (k..n).for_each(|i| column[i] = self.row(i)[k]);
            let pivot = column[k];
            // False for NaN.
            let is_positive = pivot > 0.0;
            if !is_positive {
                return Ok(false);
            }
            for (i, factor) in column.iter().map(|c| c / pivot).enumerate() {
                let row = &mut self.row_mut(i)[..=i];
                if i == k {
                    row.iter_mut().zip(&column).for_each(|(a, c)| *a = c / pivot);
                    row[k] = -1.0 / pivot;
                } else {
                    add(row, -factor, &column);
                    if i > k {
                        row[k] = factor;
                    }
                }
            }
        }
        // Sweeps of all pivots leave the negative inverse.
        for i in 0..n {
            for j in 0..=i {
                let entry = -self.entries[i * n + j];
                self.entries[i * n + j] = entry;
                self.entries[j * n + i] = entry;
            }
        }
        Ok(true)
    }
}

/// Adds `factor b` to `a`; further entries of b are ignored.
fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

/// Coefficients of order 0 and of the others, of norm 1.
const UNITS: [Complex<f64>; 3] = [
    Complex { re: 1.0, im: 0.0 },
    Complex { re: FRAC_1_SQRT_2, im: 0.0 },
    Complex { re: 0.0, im: FRAC_1_SQRT_2 },
];

/// Returns the components of a degree.
pub(super) fn components(alm: &Alm, l: usize) -> impl Iterator<Item = f64> {
    let others = (1..=l).flat_map(move |m| {
        let a = SQRT_2 * alm[(l, m)];
        [a.re, a.im]
    });
    std::iter::once(alm[(l, 0)].re).chain(others)
}
