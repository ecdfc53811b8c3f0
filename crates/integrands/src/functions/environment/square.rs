use std::f64::consts::TAU;

use num_complex::Complex;
use sphvar_sh::{Alm, Domain, GaussLegendre};
use sphvar_sht::{RingTransform, RingWorkspace};

use super::EnvironmentMap;
use crate::{Coefficients, Error};

impl EnvironmentMap {
    /// Returns the coefficients of the square of the map on the sphere, to rounding.
    ///
    /// Between texel centres the square is a polynomial of degree 2 in each angle. With
    /// `f = (1 - u) a_j + u a_{j+1}` between the centres j and j + 1 of a row, the product of two
    /// rows a and b has the Fourier integrals
    ///
    /// ```text
    /// sum_j e^{-i m phi_j} (2 Re(k_0) a_j b_j + k_1 (a_j b_{j+1} + a_{j+1} b_j))
    /// k_0 = step int_0^1 (1 - u)^2 e^{-i m step u} du,   k_1 = step int_0^1 u (1 - u) e^{-i m step u} du
    /// ```
    ///
    /// Cost: some `3 lmax` operations per texel and `12 H` rings.
    pub(super) fn square(&self, lmax: usize) -> Result<Coefficients, Error> {
        let nodes = self.nodes(Domain::Sphere, lmax + 2)?;
        let kernels = self.kernels(lmax)?;
        let mut alm = Alm::zeros(lmax)?;
        RingTransform::new(lmax)?.adjoint_into(
            nodes.iter().map(|n| n.colatitude),
            |m, fourier| {
                let rows = self.row_products(m, kernels[m]);
                for (f, node) in fourier.iter_mut().zip(&nodes) {
                    let ((i, j), t) = (node.rows, node.share);
                    let s = 1.0 - t;
                    // Beyond the ends both rows are the same.
                    let mixed = if i == j { rows[i].0 } else { rows[i].1 };
                    let value = rows[i].0 * (s * s) + mixed * (2.0 * s * t) + rows[j].0 * (t * t);
                    *f = value * node.weight;
                }
            },
            &mut RingWorkspace::default(),
            &mut alm,
        );
        Ok(Coefficients::general(alm))
    }

    /// Returns `2 Re(k_0)` and `k_1` for every order.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small number of nodes"
    )]
    fn kernels(&self, lmax: usize) -> Result<Vec<(f64, Complex<f64>)>, Error> {
        let step = TAU / self.width as f64;
        let rule = GaussLegendre::new((0.5 * lmax as f64 * step) as usize + 16)?;
        let kernel = |m: usize| {
            let (mut square, mut mixed) = (0.0, Complex::ZERO);
            for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
                let u = 0.5 * (1.0 + x);
                let wave = Complex::cis(-(m as f64) * step * u) * (0.5 * w * step);
                square += 2.0 * (1.0 - u) * (1.0 - u) * wave.re;
                mixed += wave * (u * (1.0 - u));
            }
            (square, mixed)
        };
        Ok((0..=lmax).map(kernel).collect())
    }

    /// Returns the Fourier integrals of order m of the square of each row and of its product with
    /// the next row.
    fn row_products(
        &self,
        m: usize,
        kernel: (f64, Complex<f64>),
    ) -> Vec<(Complex<f64>, Complex<f64>)> {
        let step = TAU / self.width as f64;
        let order = m as f64;
        let phase =
            |j: usize| Complex::cis(-order * (self.first_longitude + (j as f64 + 0.5) * step));
        let phases: Vec<Complex<f64>> = (0..self.width).map(phase).collect();
        let product = |a: &[f64], b: &[f64]| -> Complex<f64> {
            let term = |(j, phase): (usize, &Complex<f64>)| {
                let k = (j + 1) % self.width;
                phase * (kernel.1 * (a[j] * b[k] + a[k] * b[j]) + kernel.0 * a[j] * b[j])
            };
            phases.iter().enumerate().map(term).sum()
        };
        (0..self.height)
            .map(|i| {
                let (row, next) = (self.row(i), self.row((i + 1).min(self.height - 1)));
                (product(row, row), product(row, next))
            })
            .collect()
    }
}
