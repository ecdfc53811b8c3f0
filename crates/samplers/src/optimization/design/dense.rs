use std::f64::consts::PI;

use glam::DVec3;

use super::jacobian::{Jacobian, axes};
use super::matrix::{Matrix, dot};
use super::{DesignEquations, Solved};
use crate::{Error, Progress};

/// Degrees above that of the design whose power the first steps lower too, and the factor of their
/// weights: without them the power there is several times larger.
const SOFT_DEGREES: usize = 3;
const SOFT_WEIGHT: f64 = 0.1;

/// The first steps end when one lowers the sum of squares by less than this fraction.
const SOFT_END: f64 = 0.02;

/// Maximum number of steps.
const MAX_STEPS: u32 = 150;

/// Maximum number of times that the damping of a step is increased.
const MAX_TRIALS: u32 = 12;

/// The smallest damping: that of rounding errors.
const MIN_DAMPING: f64 = 1e-15;

/// Moves the points until every power of the equations is at most `tolerance`, by the method of
/// Levenberg 1944 and Marquardt 1963 with dense matrices.
///
/// A step solves `(J J^T + mu) y = -r`, `omega = J^T y` for the values r of n equations and their
/// Jacobian J, with n^2 (2N + n/3) operations. The damping mu follows the ratio of the actual to
/// the predicted decrease. Convergence is quadratic once the damping is small.
///
/// # Errors
///
/// [`Error::Infeasible`] if the steps stall; [`Error::Stopped`]; [`Error::OutOfMemory`];
/// [`Error::Degree`] if the degree is too large.
pub(super) fn solve_dense(
    equations: DesignEquations,
    points: &mut Vec<DVec3>,
    tolerance: f64,
    progress: &dyn Progress,
) -> Result<Solved, Error> {
    let mut search = Search { equations, tolerance, progress, damping: 1e-2, iterations: 0 };
    let soft = Jacobian::new(equations, SOFT_DEGREES, SOFT_WEIGHT)?;
    search.descend(&soft, points, SOFT_END)?;
    let exact = Jacobian::new(equations, 0, 1.0)?;
    let residual = search.descend(&exact, points, 0.0)?;
    let iterations = search.iterations;
    if residual <= tolerance {
        Ok(Solved { residual, iterations })
    } else {
        Err(equations.stalled(points.len(), iterations, residual))
    }
}

struct Search<'a> {
    equations: DesignEquations,
    tolerance: f64,
    progress: &'a dyn Progress,
    damping: f64,
    iterations: u32,
}

impl Search<'_> {
    /// Moves the points until the powers are within the tolerance, no step lowers the sum of
    /// squares, or one lowers it by less than the fraction `least`; returns the largest power.
    fn descend(
        &mut self,
        jacobian: &Jacobian,
        points: &mut Vec<DVec3>,
        least: f64,
    ) -> Result<f64, Error> {
        let (n_equations, n_points) = (jacobian.n_equations(), points.len());
        if n_equations == 0 {
            return Ok(0.0);
        }
        let mut derivatives = Matrix::zeros(n_equations, 2 * n_points)?;
        let mut gram = Matrix::zeros(n_equations, n_equations)?;
        let mut factor = Matrix::zeros(n_equations, n_equations)?;
        let mut values = jacobian.values(points, self.progress)?;
        let residual =
            |values: &[f64]| self.equations.residual(&jacobian.squares(values, n_points), n_points);
        while residual(&values) > self.tolerance && self.iterations < MAX_STEPS {
            self.iterations += 1;
            self.progress.tick(step_work(n_equations, n_points))?;
            jacobian.derivatives(points, &mut derivatives, self.progress)?;
            derivatives.gram_into(&mut gram, self.progress)?;
            let before = dot(&values, &values);
            let mut trials = 0;
            let after = loop {
                if trials == MAX_TRIALS {
                    return Ok(residual(&values));
                }
                trials += 1;
                if !factor.factor(&gram, self.damping, self.progress)? {
                    self.damping *= 10.0;
                    continue;
                }
                let (moved, predicted) = self.step(&derivatives, &factor, &values, points);
                let there = jacobian.values(&moved, self.progress)?;
                let after = dot(&there, &there);
                let ratio = (before - after) / predicted;
                if ratio.is_nan() || ratio <= 1e-3 {
                    self.damping *= 5.0;
                    continue;
                }
                self.damping *= match ratio {
                    0.9.. => 0.1,
                    0.75.. => 1.0 / 3.0,
                    ..0.25 => 3.0,
                    _ => 1.0,
                };
                self.damping = self.damping.max(MIN_DAMPING);
                *points = moved;
                values = there;
                break after;
            };
            if before - after < least * before {
                break;
            }
        }
        Ok(residual(&values))
    }

    /// Returns the points after a step, and the decrease of the sum of squares that the linear model
    /// predicts, `omega J^T r + mu omega^2`.
    fn step(
        &self,
        derivatives: &Matrix,
        factor: &Matrix,
        values: &[f64],
        points: &[DVec3],
    ) -> (Vec<DVec3>, f64) {
        let mut y: Vec<f64> = values.iter().map(|value| -value).collect();
        factor.solve(&mut y);
        let (mut step, mut slope) = (vec![0.0; 2 * points.len()], vec![0.0; 2 * points.len()]);
        for i in 0..derivatives.n_rows() {
            let row = derivatives.row(i);
            for ((s, g), d) in step.iter_mut().zip(&mut slope).zip(row) {
                *s += y[i] * d;
                *g += values[i] * d;
            }
        }
        let predicted = self.damping * dot(&step, &step) - dot(&step, &slope);
        let reach = 0.5 * (4.0 * PI / points.len() as f64).sqrt();
        let moved = points.iter().zip(step.as_chunks::<2>().0).map(|(&point, &[a, b])| {
            let [first, second] = axes(point);
            let omega = (a * first + b * second).clamp_length_max(reach);
            (point + omega.cross(point)).normalize()
        });
        (moved.collect(), predicted)
    }
}

/// Returns the expected nominal work of [`solve_dense`].
pub(super) fn expected_work(equations: DesignEquations, n_points: usize) -> f64 {
    const STEPS: f64 = 60.0;
    STEPS * step_work(equations.count(), n_points)
}

/// Returns the nominal work of a step: a unit is about 600 operations of matrix products.
fn step_work(n_equations: usize, n_points: usize) -> f64 {
    let n = n_equations as f64;
    n * n * (2.0 * n_points as f64 + n / 3.0) / 600.0
}
