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

/// An approximate solution of a system `A x = b` of coefficients of real functions, A symmetric and
/// positive semidefinite, by conjugate gradients (Hestenes and Stiefel 1952).
#[derive(Clone, Debug)]
pub struct ConjugateGradients {
    /// The solution.
    pub x: Alm,
    /// The norm of the residual, as far as the iteration knows it.
    pub residual: f64,
    /// The number of products with A.
    pub iterations: usize,
    /// The extreme eigenvalues of A on the space that the right-hand side generates, by the method
    /// of Lanczos: approximations from within. `None` without iterations.
    pub eigenvalues: Option<(f64, f64)>,
}

impl ConjugateGradients {
    /// Iterates from x = 0, given as `zero`, until the residual has the norm `tolerance` or for
    /// `max_iterations`; `apply` writes the product of A with its first argument to the second.
    ///
    /// The norm of coefficients counts orders m > 0 for both m and -m. The coefficients of the
    /// iteration are the entries of the tridiagonal matrix of Lanczos (Golub and Van Loan 2013,
    /// section 11.3.5), whose extreme eigenvalues approximate those of the system.
    ///
    /// # Errors
    ///
    /// Those of `apply`, which end the iteration.
    pub fn run<E>(
        zero: Alm,
        b: &Alm,
        tolerance: f64,
        max_iterations: usize,
        mut apply: impl FnMut(&Alm, &mut Alm) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut x = zero;
        let mut image = x.clone();
        let (mut residual, mut direction) = (b.clone(), b.clone());
        let mut square = dot(b, b);
        let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
        let (mut iterations, mut carried) = (0, 0.0);
        while square.sqrt() > tolerance && iterations < max_iterations {
            apply(&direction, &mut image)?;
            let curvature = dot(&direction, &image);
            // A direction in the kernel of A cannot reduce the residual.
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
        Ok(Self { x, residual: square.sqrt(), iterations, eigenvalues })
    }

    /// Returns the condition number of a factor of A, estimated from within: infinite if A is found
    /// singular.
    #[must_use]
    pub fn condition(&self) -> f64 {
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
    /// Solves the system by conjugate gradients until the residual has the norm `tolerance` or for
    /// `max_iterations`.
    pub(crate) fn solve(
        &mut self,
        b: &Alm,
        tolerance: f64,
        max_iterations: usize,
        watch: Watch<'_>,
    ) -> Result<ConjugateGradients, SolveError> {
        let zero = Alm::zeros(b.lmax())?;
        let apply = |x: &Alm, image: &mut Alm| {
            if watch().is_break() {
                return Err(SolveError::Stopped);
            }
            self.matrix.apply(x, image);
            add(image, self.shift, x);
            Ok(())
        };
        ConjugateGradients::run(zero, b, tolerance, max_iterations, apply)
    }
}
