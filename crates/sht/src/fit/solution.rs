use sphvar_sh::Alm;

use super::inverse::Inverse;
use super::{FitError, LeastSquares};
use crate::normal_equations::{Harmonics, Watch, add, dot};

/// The largest number of passes; two reach the accuracy of the transforms.
const MAX_PASSES: usize = 4;
/// The gradient at which the iteration ends, relative to the bound of its size.
const TOLERANCE: f64 = 1e-12;
/// The largest gradient of a solution, which the roundings of sums over the points stay below.
const MAX_GRADIENT: f64 = 1e-11;

/// The minimizer, for values and weights that are divided by the largest.
pub(super) struct Solution {
    pub(super) alm: Alm,
    /// The sum of `w r^2` over the residuals r.
    pub(super) weighted_square: f64,
    pub(super) iterations: usize,
}

impl Solution {
    /// Solves the normal equations by conjugate gradients with iterative refinement: the gradient
    /// `B W (y - B^T F) - ridge F` at the points replaces that of the iteration, which accumulates
    /// rounding errors. Returns `None` if they do not converge.
    pub(super) fn of(
        problem: &LeastSquares<'_>,
        harmonics: &mut Harmonics<'_>,
        inverse: &mut Inverse<'_>,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, FitError> {
        let weight = |k: usize| problem.weights.get(k).copied().unwrap_or(1.0);
        let square = |v: &[f64]| v.iter().enumerate().map(|(k, v)| weight(k) * v * v).sum::<f64>();
        // |B W y| <= sqrt(|M|) |sqrt(W) y|.
        let scale = (inverse.mean_eigenvalue() * square(&problem.values)).sqrt();
        let mut best = Self { alm: harmonics.zeros()?, weighted_square: 0.0, iterations: 0 };
        let mut alm = best.alm.clone();
        let (mut residuals, mut weighted) = (problem.values.clone(), problem.values.clone());
        let mut gradient = harmonics.zeros()?;
        let (mut size, mut n_iterations) = (f64::INFINITY, 0);
        for pass in 0..=MAX_PASSES {
            if pass > 0 {
                harmonics.values(&alm, &mut residuals);
                residuals.iter_mut().zip(&problem.values).for_each(|(f, y)| *f = y - *f);
            }
            weighted.iter_mut().enumerate().for_each(|(k, v)| *v = weight(k) * residuals[k]);
            harmonics.coefficients(&weighted, &mut gradient);
            add(&mut gradient, -inverse.ridge(), &alm);
            let previous = size;
            size = dot(&gradient, &gradient).sqrt();
            if size < previous {
                best.alm.clone_from(&alm);
                best.weighted_square = square(&residuals);
            }
            let is_resolved = size <= 2.0 * TOLERANCE * scale || size >= 0.5 * previous;
            if is_resolved || pass == MAX_PASSES {
                size = size.min(previous);
                break;
            }
            let step = inverse.solve(&gradient, TOLERANCE * scale, watch)?;
            n_iterations += step.iterations;
            add(&mut alm, 1.0, &step.x);
        }
        best.iterations = n_iterations;
        // False for NaN.
        let has_converged = size <= MAX_GRADIENT * scale;
        Ok(has_converged.then_some(best))
    }
}
