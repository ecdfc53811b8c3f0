use sphvar_sh::{Alm, Domain};

use super::LeastSquares;
use crate::normal_equations::{ConjugateGradients, NormalMatrix, SolveError, System, Watch, add};

/// The inverse of the normal equations `M = A + ridge I`, `A = B W B^T`: a solver that records
/// extreme eigenvalues.
pub(super) struct Inverse<'a> {
    domain: Domain,
    lmax: usize,
    matrix: NormalMatrix<'a>,
    ridge: f64,
    /// The mean eigenvalue of A, `sum w/(4 pi)`.
    mean_eigenvalue: f64,
    /// The smallest and largest eigenvalue of M found so far.
    extremes: (f64, f64),
    /// The largest number of iterations for one right-hand side.
    iterations: usize,
}

impl<'a> Inverse<'a> {
    pub(super) fn new(
        domain: Domain,
        lmax: usize,
        matrix: NormalMatrix<'a>,
        ridge: f64,
        mean_eigenvalue: f64,
    ) -> Self {
        let extremes = (f64::INFINITY, 0.0);
        Self { domain, lmax, matrix, ridge, mean_eigenvalue, extremes, iterations: 0 }
    }

    pub(super) fn domain(&self) -> Domain {
        self.domain
    }

    pub(super) fn lmax(&self) -> usize {
        self.lmax
    }

    pub(super) fn ridge(&self) -> f64 {
        self.ridge
    }

    /// Returns the mean eigenvalue of M, `sum w/(4 pi) + ridge`.
    pub(super) fn mean_eigenvalue(&self) -> f64 {
        self.mean_eigenvalue + self.ridge
    }

    /// Returns the condition number of a factor of M.
    pub(super) fn condition(&self) -> f64 {
        let (smallest, largest) = self.extremes;
        match largest > 0.0 {
            true if smallest > 0.0 => (largest / smallest).sqrt().max(1.0),
            true => f64::INFINITY,
            false => 1.0,
        }
    }

    /// Returns the smallest eigenvalue of M that was found; infinite if none was.
    pub(super) fn smallest_eigenvalue(&self) -> f64 {
        self.extremes.0
    }

    /// Returns the largest eigenvalue of M that was found.
    pub(super) fn largest_eigenvalue(&self) -> f64 {
        self.extremes.1
    }

    /// Returns the largest number of iterations for one right-hand side.
    pub(super) fn iterations(&self) -> usize {
        self.iterations
    }

    /// Writes `A x`.
    pub(super) fn apply(&mut self, x: &Alm, out: &mut Alm) {
        self.matrix.apply(x, out);
    }

    /// Writes `M x`.
    pub(super) fn apply_with_ridge(&mut self, x: &Alm, out: &mut Alm) {
        self.matrix.apply(x, out);
        add(out, self.ridge, x);
    }

    /// Solves `M x = b` until the residual has the norm `tolerance`.
    pub(super) fn solve(
        &mut self,
        b: &Alm,
        tolerance: f64,
        watch: Watch<'_>,
    ) -> Result<ConjugateGradients, SolveError> {
        let mut system = System { matrix: &mut self.matrix, shift: self.ridge };
        let solution = system.solve(b, tolerance, LeastSquares::MAX_ITERATIONS, watch)?;
        self.iterations = self.iterations.max(solution.iterations);
        if let Some((smallest, largest)) = solution.eigenvalues {
            self.extremes = (self.extremes.0.min(smallest), self.extremes.1.max(largest));
        }
        Ok(solution)
    }
}
