//! Least-squares fits of harmonics to scattered values.

mod covariance;
mod error;
mod inverse;
mod noise;
mod solution;
mod traces;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use sphvar_sh::{Alm, Domain};

pub use self::error::FitError;
use self::inverse::Inverse;
use self::noise::Noise;
use self::solution::Solution;
use crate::normal_equations::{Harmonics, NormalMatrix, largest_degree, n_distinct, n_harmonics};

/// The problem of fitting spherical harmonics to values at scattered points.
///
/// The coefficients `F_lm`, l <= L, of the fit minimize
///
/// ```text
/// sum_k w_k (y_k - f(x_k))^2 + ridge sum_lm |F_lm|^2,      f(x) = sum_lm F_lm Y_lm(x),
/// ```
///
/// for values `y_k` with weights `w_k` (1 unless given). On the hemisphere, f has even degrees
/// only, and `F_lm` are the coefficients of its even extension to the sphere.
///
/// # Noise
///
/// Errors and corrected energies assume values `y_k = f(x_k) + e_k` with independent errors of mean
/// 0 and variance `sigma^2/w_k`; whatever of the function lies beyond degree L counts as noise.
/// With the matrix `M = B W B^T + ridge I` of the normal equations, where B has one row for each
/// harmonic, the coefficients have the covariance `sigma^2 C`, `C = M^-1 B W B^T M^-1`, which is
/// `M^-1` without a ridge. The sum of squares of the residuals has the mean
/// `sigma^2 (N - P + ridge^2 tr M^-2)` for P harmonics, from which `sigma^2` follows. A ridge also draws the
/// coefficients towards 0; neither energies nor errors account for that.
///
/// # Examples
///
/// ```
/// use std::ops::ControlFlow;
/// use glam::DVec3;
/// use sphvar_sh::Domain;
/// use sphvar_sht::LeastSquares;
///
/// // f = 2 + z at the vertices of an octahedron: F_00 = 2 sqrt(4 pi), F_10 = sqrt(4 pi/3).
/// let points = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
/// let values = points.map(|p| 2.0 + p.z);
/// let problem = LeastSquares::new(&points, &values, Domain::Sphere)?;
/// let fit = problem.solve(1, &mut || ControlFlow::Continue(()))?;
/// assert!((fit.alm[(0, 0)].re - 2.0 * (4.0 * std::f64::consts::PI).sqrt()).abs() < 1e-12);
/// assert!((fit.alm[(1, 0)].re - (4.0 * std::f64::consts::PI / 3.0).sqrt()).abs() < 1e-12);
/// # Ok::<(), sphvar_sht::FitError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LeastSquares<'a> {
    points: &'a [DVec3],
    domain: Domain,
    /// Divided by `value_scale`.
    values: Vec<f64>,
    /// The largest magnitude of the values.
    value_scale: f64,
    /// Divided by `weight_scale`; empty if all are 1.
    weights: Vec<f64>,
    /// The largest weight.
    weight_scale: f64,
    ridge: f64,
    n_used: usize,
    n_distinct: usize,
}

/// A least-squares fit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// The coefficients.
    pub alm: Alm,
    /// The domain of the points.
    pub domain: Domain,
    /// The root mean square of the residuals, `sqrt(sum w r^2/sum w)`, in units of the values.
    pub residual_rms: f64,
    /// The estimated condition number in the 2-norm of the matrix of the least-squares problem: the
    /// weighted harmonics at the points, with the rows of the ridge if there is one. The method of
    /// Lanczos estimates it from within, to some percent.
    pub condition: f64,
    /// The number of iterations of conjugate gradients for the coefficients.
    pub iterations: usize,
    /// The number of points of positive weight minus that of harmonics, `N - P + ridge^2 tr M^-2`.
    pub degrees_of_freedom: f64,
    /// The variance `sigma^2` of the noise of a value of weight 1, from the residuals; `None`
    /// without degrees of freedom.
    pub noise_variance: Option<f64>,
    /// The energy of each degree from 0.
    pub energies: Vec<FittedEnergy>,
}

/// The energy of a degree of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FittedEnergy {
    /// The energy `sum_m |F_lm|^2` of the fit, which includes that of the noise.
    pub fitted: f64,
    /// The mean energy of the noise, `sigma^2 tr_l C`; `None` if `sigma^2` is unknown.
    pub noise: Option<f64>,
    /// The energy without that of the noise, an unbiased estimate, which may be negative.
    pub corrected: Option<f64>,
    /// The standard error of `corrected`.
    pub stderr: Option<f64>,
}

impl<'a> LeastSquares<'a> {
    /// The range of the largest absolute value of the values, unless all are 0.
    pub const MAGNITUDES: [f64; 2] = [1e-150, 1e150];
    /// The largest number of iterations for one right-hand side. That number reduces the error by
    /// 1e-12 up to a condition number of about 70.
    pub const MAX_ITERATIONS: usize = 1000;
    /// The largest condition number of fits. Beyond it the normal equations, whose condition number
    /// is its square, leave fewer than about four digits of the coefficients.
    pub const MAX_CONDITION: f64 = 1e5;

    /// Returns the problem for values at unit vectors.
    ///
    /// # Errors
    ///
    /// [`FitError::NoPoints`], [`FitError::Lengths`] if the numbers of points and values differ,
    /// [`FitError::Value`] if a value is not finite, [`FitError::Magnitude`] if the largest is outside
    /// [`MAGNITUDES`](Self::MAGNITUDES).
    pub fn new(points: &'a [DVec3], values: &[f64], domain: Domain) -> Result<Self, FitError> {
        if points.is_empty() {
            return Err(FitError::NoPoints);
        }
        check_length("values", points, values)?;
        if let Some(index) = values.iter().position(|y| !y.is_finite()) {
            return Err(FitError::Value { index, value: values[index] });
        }
        let largest = values.iter().fold(0.0, |max: f64, y| max.max(y.abs()));
        let [min, max] = Self::MAGNITUDES;
        if largest != 0.0 && !(min..=max).contains(&largest) {
            return Err(FitError::Magnitude { got: largest });
        }
        let value_scale = if largest > 0.0 { largest } else { 1.0 };
        Ok(Self {
            points,
            domain,
            values: values.iter().map(|y| y / value_scale).collect(),
            value_scale,
            weights: Vec::new(),
            weight_scale: 1.0,
            ridge: 0.0,
            n_used: points.len(),
            n_distinct: n_distinct(points.iter(), domain),
        })
    }

    /// Sets the weights; those that are inversely proportional to the variances of the values give
    /// the coefficients of least variance. Points of weight 0 are not used.
    ///
    /// # Errors
    ///
    /// [`FitError::Lengths`] unless there is one weight for each point, [`FitError::Weight`] if one
    /// is negative or not finite, [`FitError::NoWeight`] if all are 0.
    pub fn with_weights(mut self, weights: &[f64]) -> Result<Self, FitError> {
        check_length("weights", self.points, weights)?;
        let is_weight = |w: f64| w.is_finite() && w >= 0.0;
        if let Some(index) = weights.iter().position(|w| !is_weight(*w)) {
            return Err(FitError::Weight { index, weight: weights[index] });
        }
        self.weight_scale = weights.iter().copied().fold(0.0, f64::max);
        if self.weight_scale == 0.0 {
            return Err(FitError::NoWeight);
        }
        // A subnormal scale has no finite inverse.
        self.weights = weights.iter().map(|w| w / self.weight_scale).collect();
        let used = || self.points.iter().zip(&self.weights).filter(|(_, w)| **w > 0.0);
        self.n_used = used().count();
        self.n_distinct = n_distinct(used().map(|(p, _)| p), self.domain);
        Ok(self)
    }

    /// Sets the factor of `sum |F_lm|^2` in the minimized sum, 0 unless set.
    ///
    /// It determines coefficients that the points leave open. Its scale is that of the mean
    /// eigenvalue of the normal equations, `sum w/(4 pi)`.
    ///
    /// # Errors
    ///
    /// [`FitError::Ridge`] unless it is finite and at least 0.
    pub fn with_ridge(mut self, ridge: f64) -> Result<Self, FitError> {
        if ridge.is_finite() && ridge >= 0.0 {
            self.ridge = ridge;
            Ok(self)
        } else {
            Err(FitError::Ridge { got: ridge })
        }
    }

    /// Returns the number of distinct points of positive weight; on the hemisphere antipodes are
    /// the same point.
    #[must_use]
    pub fn n_distinct(&self) -> usize {
        self.n_distinct
    }

    /// Returns the largest degree that has no more harmonics than there are distinct points.
    #[must_use]
    pub fn largest_possible_degree(&self) -> usize {
        largest_degree(self.domain, self.n_distinct)
    }

    /// Returns the fit to degree `lmax`.
    ///
    /// Conjugate gradients solve the normal equations, with refinement by residuals at the
    /// points. `watch` is called at every iteration; it stops the work by `Break`.
    ///
    /// Up to 961 harmonics (degree 30 on the sphere, 42 on the hemisphere), the covariance C is
    /// exact. With the block `C_l` of a degree, the error of its energy contains the variance
    /// `4 sigma^2 (F_l^T C_l F_l - sigma^2 tr C_l^2) + 2 sigma^4 tr C_l^2`, where the parenthesis is
    /// 0 if negative, and that of `sigma^2`. It is for Gaussian noise. Where noise exceeds the
    /// energy of the function, it is an upper bound.
    ///
    /// Beyond, `tr_l M^-1` is the mean of `sum_m z_lm (M^-1 z)_lm` over vectors z of independent
    /// random signs (Hutchinson 1990), if it helps less its regression on `sum_m z_lm (M z)_lm`,
    /// whose mean `tr_l M = (2l + 1) sum w/(4 pi)` (for no ridge) is exact. Entries of the inverse off
    /// the diagonal cause its variance, which is at most twice the sum of their squares. From 4 to
    /// 12 vectors are used, until that is half of the variance of the noise's energy. Errors contain
    /// this variance, an upper bound that is large for condition numbers above about 20, and take
    /// the noise of a degree as isotropic, `C_l = I tr_l C/(2l + 1)`.
    ///
    /// # Errors
    ///
    /// [`FitError::TooFewPoints`] if there are more harmonics than distinct points,
    /// [`FitError::IllConditioned`] if the points do not determine the coefficients, as where they
    /// leave large gaps, [`FitError::Stopped`], and those of transforms.
    ///
    /// # Performance
    ///
    /// The cost of an iteration does not depend on the number of points: it is that of transforms
    /// between coefficients and a grid of about `2 (2 lmax + 1)^2` nodes. The number of iterations
    /// is about 15 times the condition number for the coefficients, and half of that for each z.
    /// The covariance of P harmonics costs P products with M, `P^3/2` multiplications and the memory
    /// of two P x P matrices: 0.4 s and 15 MB for 961 harmonics.
    ///
    /// # References
    ///
    /// Fits by iterations with transforms of scattered points: Keiner, Kunis and Potts 2007,
    /// doi:10.1007/s00041-006-6915-y. Traces: Hutchinson 1990, doi:10.1080/03610919008812866.
    pub fn solve(
        &self,
        lmax: usize,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Fit, FitError> {
        let n_harmonics = n_harmonics(self.domain, lmax);
        if n_harmonics > self.n_distinct {
            let (n_distinct, largest) = (self.n_distinct, self.largest_possible_degree());
            return Err(FitError::TooFewPoints { lmax, n_harmonics, n_distinct, largest });
        }
        let weights = (!self.weights.is_empty()).then_some(self.weights.as_slice());
        let mut harmonics = Harmonics::new(self.points, self.domain, lmax)?;
        let mut matrix = NormalMatrix::new(self.points, self.domain, lmax)?;
        matrix.set_factors(weights);
        let ridge = self.ridge / self.weight_scale;
        let sum_w = weights.map_or(self.points.len() as f64, |w| w.iter().sum());
        let mut inverse = Inverse::new(self.domain, lmax, matrix, ridge, sum_w / (4.0 * PI));
        let noise = Noise::of(&mut inverse, n_harmonics, watch)?
            .filter(|_| inverse.condition() <= Self::MAX_CONDITION)
            .ok_or_else(|| self.ill_conditioned(lmax, &inverse))?;
        let solution = Solution::of(self, &mut harmonics, &mut inverse, watch)?
            .ok_or_else(|| self.ill_conditioned(lmax, &inverse))?;
        let of_ridge = ridge * ridge * noise.square_trace();
        let freedom = self.n_used as f64 - n_harmonics as f64 + of_ridge;
        Ok(self.fit(solution, &noise, inverse.condition(), (sum_w, freedom)))
    }

    /// Returns the error of points that do not determine the coefficients.
    fn ill_conditioned(&self, lmax: usize, inverse: &Inverse<'_>) -> FitError {
        let condition = inverse.condition();
        // The eigenvalues of the normal equations have the squared condition number.
        let ridge = 1e-3 * inverse.largest_eigenvalue() * self.weight_scale;
        FitError::IllConditioned { lmax, condition, iterations: inverse.iterations(), ridge }
    }

    /// Returns the fit in units of the values and weights.
    fn fit(
        &self,
        solution: Solution,
        noise: &Noise,
        condition: f64,
        (sum_w, degrees_of_freedom): (f64, f64),
    ) -> Fit {
        let Solution { mut alm, weighted_square, iterations } = solution;
        let fitted = alm.energy_per_degree();
        let variance = (degrees_of_freedom > 0.0).then(|| weighted_square / degrees_of_freedom);
        let unit = self.value_scale * self.value_scale;
        let energies = fitted.iter().enumerate().map(|(l, &fitted)| {
            let noise = variance.map(|v| noise.energy(l, v, degrees_of_freedom, &alm));
            FittedEnergy {
                fitted: fitted * unit,
                noise: noise.map(|noise| noise.mean * unit),
                corrected: noise.map(|noise| (fitted - noise.mean) * unit),
                stderr: noise.map(|noise| noise.stderr * unit),
            }
        });
        let energies = energies.collect();
        alm.values_mut().iter_mut().for_each(|a| *a *= self.value_scale);
        Fit {
            alm,
            domain: self.domain,
            residual_rms: (weighted_square / sum_w).sqrt() * self.value_scale,
            condition,
            iterations,
            degrees_of_freedom,
            noise_variance: variance.map(|v| v * unit * self.weight_scale),
            energies,
        }
    }
}

fn check_length(what: &'static str, points: &[DVec3], numbers: &[f64]) -> Result<(), FitError> {
    let (n_points, got) = (points.len(), numbers.len());
    if n_points == got { Ok(()) } else { Err(FitError::Lengths { what, n_points, got }) }
}
