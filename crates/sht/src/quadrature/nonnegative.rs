use sphvar_sh::Alm;

use super::QuadratureError;
use crate::normal_equations::{Harmonics, NormalMatrix, System, Watch, add, dot};

/// The largest number of Newton steps; a dozen suffice where weights exist.
const MAX_STEPS: usize = 100;
/// The largest number of iterations of a Newton step, and of all steps; where weights exist, some hundreds
/// suffice for all.
const MAX_ITERATIONS: usize = 500;
const MAX_ITERATIONS_IN_ALL: usize = 1500;
/// The number of successive steps with fewer active points than harmonics after which the iteration is given
/// up: the optimum, if there is one, has hardly any freedom left.
const MAX_DEFICIENT_STEPS: usize = 3;
/// The shift of the system of a step, relative to the residual and to the mean of the diagonal. It keeps
/// the system regular where few points are active, and vanishes with the residual.
const SHIFT: f64 = 0.1;
/// Below this relative residual steps are taken whole: the dual function no longer resolves them.
const WHOLE_STEPS: f64 = 1e-6;

/// Minimizes `|w|` subject to `B w = b` and `w >= 0`, from multipliers near the solution of the
/// problem without signs. Returns the weights and the number of iterations.
///
/// The solution is `w = max(B^T x, 0)` where x maximizes the concave dual function
/// `d(x) = b.x - |max(B^T x, 0)|^2/2` (Deutsch, Li and Ward 1997). It is found by the semismooth
/// Newton method (Dontchev, Qi and Qi 2003) with conjugate gradients and backtracking. Nonnegative
/// weights of sum S satisfy `|w|^2 <= S^2`, so a dual value above `S^2/2` proves that there are
/// none.
pub(super) fn nonnegative(
    harmonics: &mut Harmonics<'_>,
    matrix: &mut NormalMatrix<'_>,
    b: &Alm,
    mut multipliers: Alm,
    (degree, n_harmonics): (usize, usize),
    sum: f64,
    watch: Watch<'_>,
) -> Result<(Vec<f64>, usize), QuadratureError> {
    let n = harmonics.n_points();
    let size = dot(b, b).sqrt();
    let positive = |values: &[f64]| values.iter().map(|v| v.max(0.0)).collect::<Vec<_>>();
    let half_square = |v: &[f64]| 0.5 * v.iter().map(|v| v.max(0.0).powi(2)).sum::<f64>();
    let (mut values, mut changes) = (vec![0.0; n], vec![0.0; n]);
    harmonics.values(&multipliers, &mut values);
    let (mut iterations, mut best) = (0, (f64::INFINITY, Vec::new()));
    let mut n_deficient = 0;
    let mut gradient = harmonics.zeros()?;
    for _ in 0..MAX_STEPS {
        if iterations >= MAX_ITERATIONS_IN_ALL {
            break;
        }
        let weights = positive(&values);
        harmonics.coefficients(&weights, &mut gradient);
        gradient.values_mut().iter_mut().zip(b.values()).for_each(|(g, b)| *g = b - *g);
        let residual = dot(&gradient, &gradient).sqrt();
        let is_resolved = residual < WHOLE_STEPS * size;
        // Rounding ends the convergence.
        if is_resolved && residual > 0.5 * best.0 {
            break;
        }
        if residual < best.0 {
            best = (residual, weights);
        }
        let dual = dot(b, &multipliers) - half_square(&values);
        if dual > 0.5 * sum * sum * (1.0 + 1e-9) {
            return Err(QuadratureError::NoNonnegative { degree });
        }
        let n_active = values.iter().filter(|v| **v > 0.0).count();
        n_deficient = if n_active < n_harmonics { n_deficient + 1 } else { 0 };
        if n_deficient >= MAX_DEFICIENT_STEPS {
            break;
        }
        let relative = residual / size;
        // The mean of the diagonal of B D B^T is the number of active points over 4 pi.
        let diagonal = n_active.max(1) as f64 / (4.0 * std::f64::consts::PI);
        let shift = SHIFT * diagonal * relative.min(0.1).powi(2).max(1e-16);
        // The slope of max(v, 0).
        let active: Vec<f64> = values.iter().map(|v| f64::from(u8::from(*v > 0.0))).collect();
        matrix.set_factors(Some(&active));
        let mut system = System { matrix, shift };
        let tolerance = residual * relative.clamp(1e-9, 0.01);
        let step = system.solve(&gradient, tolerance, MAX_ITERATIONS, watch)?;
        iterations += step.iterations;
        harmonics.values(&step.x, &mut changes);
        let slope = dot(&gradient, &step.x);
        let mut length = 1.0;
        if !is_resolved {
            let along = dot(b, &step.x);
            let before = half_square(&values);
            for _ in 0..30 {
                let after: f64 = values
                    .iter()
                    .zip(&changes)
                    .map(|(v, c)| (v + length * c).max(0.0).powi(2))
                    .sum();
                if length * along + before - 0.5 * after >= 1e-4 * length * slope {
                    break;
                }
                length *= 0.5;
            }
        }
        add(&mut multipliers, length, &step.x);
        // The values are computed anew, so that their errors do not add up.
        harmonics.values(&multipliers, &mut values);
    }
    Ok((best.1, iterations))
}
