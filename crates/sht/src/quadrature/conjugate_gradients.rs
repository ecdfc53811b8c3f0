use std::ops::ControlFlow;

use sphvar_sh::Alm;

use super::QuadratureError;
use super::harmonics::{add, dot};
use super::normal_matrix::NormalMatrix;
use super::ritz::extreme_eigenvalues;

/// The system `(B D B^T + shift I) x = b`.
pub(super) struct System<'s, 'p> {
    pub(super) matrix: &'s mut NormalMatrix<'p>,
    pub(super) shift: f64,
}

/// An approximate solution.
pub(super) struct Solution {
    pub(super) x: Alm,
    pub(super) iterations: usize,
    /// The extreme eigenvalues of the matrix on the space that the right-hand side generates, by
    /// the method of Lanczos: approximations from within.
    pub(super) eigenvalues: Option<(f64, f64)>,
}

impl Solution {
    /// Returns the condition number of a factor of the system matrix, estimated from within.
    pub(super) fn condition(&self) -> f64 {
        match self.eigenvalues {
            Some((smallest, largest)) if smallest > 0.0 => (largest / smallest).sqrt(),
            Some(_) => f64::INFINITY,
            None => 1.0,
        }
    }
}

/// Called once per iteration; `Break` stops the work.
pub(super) type Watch<'w> = &'w mut dyn FnMut() -> ControlFlow<()>;

impl System<'_, '_> {
    /// Solves the system by conjugate gradients (Hestenes and Stiefel 1952) until the residual has
    /// the norm `tolerance` or for `max_iterations`.
    ///
    /// The coefficients of the iteration are the entries of the tridiagonal matrix of Lanczos (Golub and
    /// Van Loan 2013, section 11.3.5), whose extreme eigenvalues approximate those of the system.
    pub(super) fn solve(
        &mut self,
        b: &Alm,
        tolerance: f64,
        max_iterations: usize,
        watch: Watch<'_>,
    ) -> Result<Solution, QuadratureError> {
        let mut x = Alm::zeros(b.lmax())?;
        let mut image = x.clone();
        let (mut residual, mut direction) = (b.clone(), b.clone());
        let mut square = dot(b, b);
        let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
        let (mut iterations, mut carried) = (0, 0.0);
        while square.sqrt() > tolerance && iterations < max_iterations {
            if watch().is_break() {
                return Err(QuadratureError::Stopped);
            }
            self.matrix.apply(&direction, &mut image);
            add(&mut image, self.shift, &direction);
            let curvature = dot(&direction, &image);
            // A direction without values at the points cannot reduce the residual.
            let is_positive = curvature > 0.0;
            if !is_positive {
                break;
            }
            let step = square / curvature;
            add(&mut x, step, &direction);
            add(&mut residual, -step, &image);
            let next = dot(&residual, &residual);
            let ratio = next / square;
            diagonal.push(1.0 / step + carried);
            off_diagonal.push(ratio.sqrt() / step);
            carried = ratio / step;
            for (d, r) in direction.values_mut().iter_mut().zip(residual.values()) {
                *d = r + ratio * *d;
            }
            square = next;
            iterations += 1;
        }
        Ok(Solution { x, iterations, eigenvalues: extreme_eigenvalues(&diagonal, &off_diagonal) })
    }
}
