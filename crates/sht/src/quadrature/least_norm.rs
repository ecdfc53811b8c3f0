use num_complex::Complex;
use sphvar_sh::Alm;

use super::{QuadratureError, QuadratureProblem};
use crate::normal_equations::{Harmonics, NormalMatrix, System, Watch, add, dot, project};

/// The largest number of passes; two reach the accuracy of the transforms.
const MAX_PASSES: usize = 4;
/// The residual at which the iteration ends, relative to the right-hand side: that of the transforms.
const TOLERANCE: f64 = 1e-14;

/// The fractional part of the golden ratio, whose multiples are evenly distributed modulo 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The minimizer of `|w|` subject to `B w = b`.
pub(super) struct LeastNorm {
    pub(super) weights: Vec<f64>,
    /// The x of `w = B^T x`.
    pub(super) multipliers: Alm,
    /// The sums `B w`.
    pub(super) sums: Alm,
    /// The estimated condition number of B.
    pub(super) condition: f64,
    pub(super) iterations: usize,
}

/// Solves `B B^T x = b` by conjugate gradients with iterative refinement: further passes remove the
/// rounding errors that the residual of the first has accumulated.
pub(super) fn least_norm(
    harmonics: &mut Harmonics<'_>,
    matrix: &mut NormalMatrix<'_>,
    b: &Alm,
    watch: Watch<'_>,
) -> Result<LeastNorm, QuadratureError> {
    matrix.set_factors(None);
    let mut system = System { matrix, shift: 0.0 };
    let target = TOLERANCE * dot(b, b).sqrt();
    let mut best = LeastNorm {
        weights: vec![0.0; harmonics.n_points()],
        multipliers: harmonics.zeros()?,
        sums: harmonics.zeros()?,
        condition: 1.0,
        iterations: 0,
    };
    let (mut residual, mut size) = (b.clone(), f64::INFINITY);
    for pass in 0..MAX_PASSES {
        let n_left = QuadratureProblem::MAX_ITERATIONS - best.iterations;
        let step = system.solve(&residual, target, n_left, watch)?;
        best.iterations += step.iterations;
        if pass == 0 {
            best.condition = step.condition();
        }
        let (mut multipliers, mut weights) = (best.multipliers.clone(), best.weights.clone());
        let mut sums = harmonics.zeros()?;
        add(&mut multipliers, 1.0, &step.x);
        harmonics.values(&multipliers, &mut weights);
        harmonics.coefficients(&weights, &mut sums);
        residual.clone_from(b);
        add(&mut residual, -1.0, &sums);
        let previous = size;
        size = dot(&residual, &residual).sqrt();
        if size < previous {
            best = LeastNorm { weights, multipliers, sums, ..best };
        }
        // The residual of the iteration and that of the weights differ by rounding.
        let is_resolved = size <= 2.0 * target || size >= 0.5 * previous;
        let goes_on = !is_resolved && best.iterations < QuadratureProblem::MAX_ITERATIONS;
        if !goes_on {
            break;
        }
    }
    Ok(best)
}

/// Returns the condition number of B, from within, by iterations from coefficients that contain all
/// directions: a constant function does not reach those that a symmetric set keeps apart from it.
/// With more rows than columns, these are directions of the range of B.
pub(super) fn condition_number(
    harmonics: &mut Harmonics<'_>,
    matrix: &mut NormalMatrix<'_>,
    is_overdetermined: bool,
    watch: Watch<'_>,
) -> Result<f64, QuadratureError> {
    /// The residual at which the iteration ends, relative to its start.
    const TOLERANCE: f64 = 1e-10;
    matrix.set_factors(None);
    let mut start = harmonics.zeros()?;
    let mut fractions = (1..).map(|k| (f64::from(k) * GOLDEN).fract() - 0.5);
    if is_overdetermined {
        let weights: Vec<f64> = fractions.take(harmonics.n_points()).collect();
        harmonics.coefficients(&weights, &mut start);
    } else {
        for a in start.values_mut() {
            *a = Complex::new(fractions.next().unwrap_or(0.5), fractions.next().unwrap_or(0.5));
        }
        project(harmonics.domain(), &mut start);
    }
    let target = TOLERANCE * dot(&start, &start).sqrt();
    let mut system = System { matrix, shift: 0.0 };
    let solution = system.solve(&start, target, QuadratureProblem::MAX_ITERATIONS, watch)?;
    Ok(solution.condition())
}
