use std::ops::ControlFlow;

use sphvar_sh::{Alm, Error};

use super::harmonics::{add, dot};
use super::normal_matrix::NormalMatrix;
use super::ritz::extreme_eigenvalues;

/// The system `(B D B^T + shift I) x = b`.
pub(crate) struct System<'s, 'p> {
    pub(crate) matrix: &'s mut NormalMatrix<'p>,
    pub(crate) shift: f64,
}

/// An approximate solution.
pub(crate) struct SystemSolution {
    pub(crate) x: Alm,
    /// The norm of the residual, as far as the iteration knows it.
    pub(crate) residual: f64,
    pub(crate) iterations: usize,
    /// The extreme eigenvalues of the matrix on the space that the right-hand side generates, by
    /// the method of Lanczos: approximations from within.
    pub(crate) eigenvalues: Option<(f64, f64)>,
}

impl SystemSolution {
    /// Returns the condition number of a factor of the system matrix, estimated from within.
    pub(crate) fn condition(&self) -> f64 {
        match self.eigenvalues {
            Some((smallest, largest)) if smallest > 0.0 => (largest / smallest).sqrt(),
            Some(_) => f64::INFINITY,
            None => 1.0,
        }
    }
}

/// The reason why a system is not solved.
#[derive(Debug)]
pub(crate) enum SolveError {
    /// The caller stopped the work.
    Stopped,
    /// Memory is exhausted.
    Memory(Error),
}

impl From<Error> for SolveError {
    fn from(error: Error) -> Self {
        Self::Memory(error)
    }
}

/// Called once per iteration; `Break` stops the work.
pub(crate) type Watch<'w> = &'w mut dyn FnMut() -> ControlFlow<()>;

impl System<'_, '_> {
    /// Solves the system by conjugate gradients (Hestenes and Stiefel 1952) until the residual has
    /// the norm `tolerance` or for `max_iterations`.
    ///
    /// The coefficients of the iteration are the entries of the tridiagonal matrix of Lanczos
    /// (Golub and Van Loan 2013, section 11.3.5), whose extreme eigenvalues approximate those of
    /// the system.
    pub(crate) fn solve(
        &mut self,
        b: &Alm,
        tolerance: f64,
        max_iterations: usize,
        watch: Watch<'_>,
    ) -> Result<SystemSolution, SolveError> {
        let mut x = Alm::zeros(b.lmax())?;
        let mut image = x.clone();
        let (mut residual, mut direction) = (b.clone(), b.clone());
        let mut square = dot(b, b);
        let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
        let (mut iterations, mut carried) = (0, 0.0);
        while square.sqrt() > tolerance && iterations < max_iterations {
            if watch().is_break() {
                return Err(SolveError::Stopped);
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
        let eigenvalues = extreme_eigenvalues(&diagonal, &off_diagonal);
        Ok(SystemSolution { x, residual: square.sqrt(), iterations, eigenvalues })
    }
}
