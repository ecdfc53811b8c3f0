//! Quadrature weights of given points.

mod least_norm;
mod nonnegative;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Alm, Domain, Error};

use self::least_norm::{condition_number, least_norm};
use self::nonnegative::nonnegative;
use crate::normal_equations::{
    Harmonics, NormalMatrix, SolveError, largest_degree, n_distinct, n_harmonics,
};

/// The weights of a problem that are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WeightSigns {
    /// Weights of any sign: those of least norm.
    #[default]
    Any,
    /// Weights of at least 0: of those, the ones of least norm.
    Nonnegative,
}

/// The problem of finding quadrature weights for given points.
///
/// Weights w of points x are exact to degree t if
///
/// ```text
/// sum_k w_k Y_lm(x_k) = 0   for 1 <= l <= t and all m,      sum_k w_k = area,
/// ```
///
/// with the area 4 pi of the sphere, or 2 pi of the hemisphere, where only even degrees count. Of all
/// such weights those of the least norm `sum w_k^2` have the least variance for noise in the values,
/// which is their largest effective number of points `(sum w)^2/sum w^2`.
///
/// Degree t needs as many distinct points as there are harmonics, `(t + 1)^2`, or `(t + 1)(t + 2)/2`
/// for even t on the hemisphere; fewer suffice only for the points of quadrature rules of degree t.
/// Repeated points share their weight equally.
///
/// # Examples
///
/// ```
/// use std::ops::ControlFlow;
/// use glam::DVec3;
/// use sphvar_sh::Domain;
/// use sphvar_sht::{QuadratureProblem, WeightSigns};
///
/// // The octahedron, with one vertex moved by 0.1 rad.
/// let moved = DVec3::new(0.1_f64.sin(), 0.0, 0.1_f64.cos());
/// let points = [moved, -DVec3::Z, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y];
/// let problem = QuadratureProblem::new(&points, Domain::Sphere, WeightSigns::Any)?;
/// let rule = problem.solve(1, &mut || ControlFlow::Continue(()))?;
/// let centre: DVec3 = points.iter().zip(&rule.weights).map(|(p, w)| *p * *w).sum();
/// assert!(centre.length() < 1e-13);
/// # Ok::<(), sphvar_sht::QuadratureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct QuadratureProblem<'a> {
    points: &'a [DVec3],
    domain: Domain,
    signs: WeightSigns,
    n_distinct: usize,
}

/// Quadrature weights, and what they are worth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QuadratureWeights {
    /// One weight for each point; their sum is the area of the domain.
    pub weights: Vec<f64>,
    /// The requested degree.
    pub degree: usize,
    /// The largest `|sum_k w_k Y_lm(x_k)|` of a degree from 1 to `degree`, and the error of that of degree 0,
    /// relative to `|sum_k w_k Y_00|`.
    pub residual: f64,
    /// The condition number in the 2-norm of the matrix of all harmonics up to `degree` at the
    /// points, estimated from within by the method of Lanczos (Golub and Van Loan 2013, section
    /// 10.1), to about 1e-3 where it is moderate.
    pub condition: f64,
    /// The largest degree up to which the residual is at most
    /// [`QuadratureProblem::MAX_RESIDUAL`].
    pub exact_degree: usize,
    /// The number of iterations of conjugate gradients.
    pub iterations: usize,
}

/// The reason why there are no weights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum QuadratureError {
    /// There are no points.
    #[error("quadrature weights need at least 1 point, got 0")]
    NoPoints,
    /// Degree t has more harmonics than there are distinct points, which are not those of a rule.
    #[error(
        "weights exact to degree {degree} need {n_harmonics} distinct points, one for each harmonic, or the points of a rule of that degree, got {n_distinct} other points; the largest degree for points in general is {largest}"
    )]
    TooFewPoints {
        /// The requested degree.
        degree: usize,
        /// The number of harmonics up to this degree.
        n_harmonics: usize,
        /// The number of distinct points.
        n_distinct: usize,
        /// The largest degree with no more harmonics than distinct points.
        largest: usize,
    },
    /// The iteration has not converged.
    #[error(
        "weights exact to degree {degree} do not converge: the residual is {residual:.1e} after {iterations} iterations, with a condition number of at least {condition:.1e}"
    )]
    NotConverged {
        /// The requested degree.
        degree: usize,
        /// The residual that was reached.
        residual: f64,
        /// The condition number.
        condition: f64,
        /// The number of iterations.
        iterations: usize,
    },
    /// No nonnegative weights are exact to the degree, which is proven.
    #[error("no nonnegative weights of these points are exact to degree {degree}")]
    NoNonnegative {
        /// The requested degree.
        degree: usize,
    },
    /// The caller stopped the work.
    #[error("stopped")]
    Stopped,
    /// A transform is unavailable.
    #[error(transparent)]
    Transform(#[from] Error),
}

impl From<SolveError> for QuadratureError {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::Stopped => Self::Stopped,
            SolveError::Memory(error) => Self::Transform(error),
        }
    }
}

impl<'a> QuadratureProblem<'a> {
    /// The largest residual of weights, relative to their sum.
    pub const MAX_RESIDUAL: f64 = 1e-11;
    /// The largest number of iterations of weights of any sign; degrees that need more do not
    /// converge. That number reduces the error by 1e-15 up to a condition number of about 60.
    pub const MAX_ITERATIONS: usize = 1000;

    /// Returns the problem for unit vectors, on the hemisphere with z >= 0.
    ///
    /// # Errors
    ///
    /// [`QuadratureError::NoPoints`] if there are none.
    pub fn new(
        points: &'a [DVec3],
        domain: Domain,
        signs: WeightSigns,
    ) -> Result<Self, QuadratureError> {
        if points.is_empty() {
            return Err(QuadratureError::NoPoints);
        }
        Ok(Self { points, domain, signs, n_distinct: n_distinct(points.iter(), domain) })
    }

    /// Returns the number of distinct points; on the hemisphere antipodes are the same point.
    #[must_use]
    pub fn n_distinct(&self) -> usize {
        self.n_distinct
    }

    /// Returns the largest degree that has no more harmonics than there are distinct points. Only
    /// the points of quadrature rules have weights of higher degrees, to at most twice this degree
    /// and 1.
    #[must_use]
    pub fn largest_possible_degree(&self) -> usize {
        largest_degree(self.domain, self.n_distinct)
    }

    /// Returns weights that are exact to `degree`.
    ///
    /// Those of any sign are found by conjugate gradients on `B B^T x = b`, `w = B^T x`, where B is
    /// the matrix of harmonics, with iterative refinement; nonnegative ones by a Newton method on
    /// the dual problem from there. `watch` is called at every iteration; it stops the work by
    /// `Break`.
    ///
    /// # Errors
    ///
    /// [`QuadratureError::TooFewPoints`] if the degree has more harmonics than there are distinct
    /// points and these are not the points of a rule of that degree,
    /// [`QuadratureError::NotConverged`], [`QuadratureError::NoNonnegative`],
    /// [`QuadratureError::Stopped`], and those of transforms.
    ///
    /// # Performance
    ///
    /// The cost of an iteration does not depend on the number of points: it is that of transforms
    /// between coefficients and a grid of about `2 (2 degree + 1)^2` nodes. Scattered
    /// points are transformed a few times in all, or once for each Newton step of nonnegative
    /// weights. The number of iterations is about 17 times the condition number.
    ///
    /// # References
    ///
    /// Conjugate gradients: Hestenes and Stiefel 1952; weights by iterations with transforms of
    /// scattered points: Graf, Kunis and Potts 2009, doi:10.1016/j.acha.2008.12.003. Nonnegative
    /// weights: Deutsch, Li and Ward 1997 (dual problem); Dontchev, Qi and Qi 2003 (Newton method).
    pub fn solve(
        &self,
        degree: usize,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<QuadratureWeights, QuadratureError> {
        let needed = n_harmonics(self.domain, degree);
        let is_overdetermined = needed > self.n_distinct;
        let too_few = || {
            let (n_distinct, largest) = (self.n_distinct, self.largest_possible_degree());
            QuadratureError::TooFewPoints { degree, n_harmonics: needed, n_distinct, largest }
        };
        // A function of half the degree that vanishes at all points has a square whose integral is
        // positive; one exists unless the points are as many as the harmonics of that degree.
        if n_harmonics(self.domain, degree / 2) > self.n_distinct {
            return Err(too_few());
        }
        let mut harmonics = Harmonics::new(self.points, self.domain, degree)?;
        let mut matrix = NormalMatrix::new(self.points, self.domain, degree)?;
        let mut b = harmonics.zeros()?;
        let area = self.domain.area();
        let constant = area / (4.0 * PI).sqrt();
        b.values_mut()[0] = constant.into();
        let mut solution = least_norm(&mut harmonics, &mut matrix, &b, watch)?;
        if is_overdetermined {
            let mut error = solution.sums.clone();
            error.values_mut()[0] -= constant;
            let is_rule = largest(&error) <= Self::MAX_RESIDUAL * constant;
            if !is_rule {
                return Err(too_few());
            }
        }
        if self.signs == WeightSigns::Nonnegative && solution.weights.iter().any(|w| *w < 0.0) {
            let (weights, iterations) = nonnegative(
                &mut harmonics,
                &mut matrix,
                &b,
                solution.multipliers,
                (degree, needed),
                area,
                watch,
            )?;
            solution.weights = weights;
            solution.iterations += iterations;
            harmonics.coefficients(&solution.weights, &mut solution.sums);
        }
        solution.sums.values_mut()[0] -= constant;
        let residual = largest(&solution.sums) / constant;
        let (condition, iterations) = (solution.condition, solution.iterations);
        // False for NaN.
        let has_converged = residual <= Self::MAX_RESIDUAL;
        if !has_converged {
            return Err(QuadratureError::NotConverged { degree, residual, condition, iterations });
        }
        let condition =
            condition.max(condition_number(&mut harmonics, &mut matrix, is_overdetermined, watch)?);
        let exact_degree =
            exact_degree(self.points, &solution.weights, self.domain, 2 * degree + 2)?;
        let weights = solution.weights;
        Ok(QuadratureWeights { weights, degree, residual, condition, exact_degree, iterations })
    }

    /// Returns the weights of the largest degree up to `limit` for which the iteration converges,
    /// by bisection.
    ///
    /// # Errors
    ///
    /// [`QuadratureError::Stopped`], and those of transforms.
    ///
    /// # Performance
    ///
    /// About ten solutions.
    pub fn solve_largest(
        &self,
        limit: usize,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<QuadratureWeights, QuadratureError> {
        let step = self.domain.degree_step();
        // The degree fails from `failed` on, in steps; degree 0 holds for equal weights.
        let mut failed = limit.min(self.largest_possible_degree()) / step + 1;
        let mut found = self.solve(0, watch)?;
        // Random points converge to nine tenths of the number of harmonics; nonnegative weights
        // exist to half of that degree.
        let share = match self.signs {
            WeightSigns::Any => 0.9,
            WeightSigns::Nonnegative => 0.5,
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive share"
        )]
        let mut next = ((share * failed as f64) as usize).max(1);
        let mut converged = 0;
        while failed - converged > 1 {
            match self.solve(next * step, watch) {
                Ok(weights) => (converged, found) = (next, weights),
                Err(
                    QuadratureError::NotConverged { .. } | QuadratureError::NoNonnegative { .. },
                ) => {
                    failed = next;
                }
                Err(error) => return Err(error),
            }
            next = converged + (failed - converged) / 2;
        }
        Ok(found)
    }
}

/// Returns the largest absolute value of coefficients, infinity for NaN.
fn largest(alm: &Alm) -> f64 {
    let size = |a: &Complex<f64>| if a.is_nan() { f64::INFINITY } else { a.norm() };
    alm.values().iter().map(size).fold(0.0, f64::max)
}

/// Returns the largest degree up to `lmax` such that weighted points integrate all harmonics of the
/// domain from degree 1 to it with an error of at most [`QuadratureProblem::MAX_RESIDUAL`], relative
/// to the sum of the weights.
///
/// # Errors
///
/// [`Error`] if the transform to this degree is unavailable.
pub fn exact_degree(
    points: &[DVec3],
    weights: &[f64],
    domain: Domain,
    lmax: usize,
) -> Result<usize, Error> {
    let mut harmonics = Harmonics::new(points, domain, lmax)?;
    let mut sums = harmonics.zeros()?;
    harmonics.coefficients(weights, &mut sums);
    let limit = QuadratureProblem::MAX_RESIDUAL * sums.values()[0].norm();
    let is_exact = |l: usize| (0..=l).all(|m| sums[(l, m)].norm() <= limit);
    let first_error = (1..=lmax).find(|&l| !is_exact(l)).unwrap_or(lmax + 1);
    Ok((0..first_error).rev().find(|&l| domain.has_degree(l)).unwrap_or(0))
}
