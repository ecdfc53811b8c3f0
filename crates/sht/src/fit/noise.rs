use std::f64::consts::FRAC_1_SQRT_2;

use num_complex::Complex;
use sphvar_sh::{Alm, Domain};

use super::LeastSquares;
use crate::normal_equations::{
    NormalMatrix, SolveError, System, SystemSolution, Watch, add, dot, project,
};

/// The largest number of harmonics for which traces are exact.
const MAX_EXACT: usize = 49;
/// The numbers of random vectors for larger ones.
const MIN_VECTORS: usize = 2;
const MAX_VECTORS: usize = 6;
/// The variance of a trace relative to that of the noise's energy at which no more vectors are
/// needed.
const TRACE_SHARE: f64 = 0.5;
/// The residual at which the iteration for the first random vector ends. The components of the
/// vector are 1, so that one in the direction of a harmonic that the points do not see is a
/// residual of about 1, which is not overlooked.
const FIRST_TOLERANCE: f64 = 1e-3;
/// The residual for further vectors, relative to the vector. Its effect on a trace is a square.
const TOLERANCE: f64 = 3e-3;

/// The inverse of the normal equations `M = B W B^T + ridge I`: a solver that records extreme
/// eigenvalues, and the traces that determine the noise of coefficients.
pub(super) struct Inverse<'a> {
    domain: Domain,
    matrix: NormalMatrix<'a>,
    ridge: f64,
    mean_eigenvalue: f64,
    /// The smallest and largest eigenvalue of M found so far.
    extremes: (f64, f64),
    /// The largest number of iterations for one right-hand side.
    iterations: usize,
    /// `tr_l M^-1` per degree.
    traces: Vec<f64>,
    /// `tr_l M^-2` per degree.
    square_traces: Vec<f64>,
    /// The variances of `traces`.
    variances: Vec<f64>,
}

/// The energy of the noise of a degree.
#[derive(Clone, Copy)]
pub(super) struct NoiseEnergy {
    pub(super) mean: f64,
    /// The standard error of the energy from which the mean is subtracted.
    pub(super) stderr: f64,
}

impl<'a> Inverse<'a> {
    pub(super) fn new(
        domain: Domain,
        lmax: usize,
        matrix: NormalMatrix<'a>,
        ridge: f64,
        mean_eigenvalue: f64,
    ) -> Self {
        let zeros = vec![0.0; lmax + 1];
        Self {
            domain,
            matrix,
            ridge,
            mean_eigenvalue,
            extremes: (f64::INFINITY, 0.0),
            iterations: 0,
            traces: zeros.clone(),
            square_traces: zeros.clone(),
            variances: zeros,
        }
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

    /// Returns the largest eigenvalue of M that was found.
    pub(super) fn largest_eigenvalue(&self) -> f64 {
        self.extremes.1
    }

    /// Returns the largest number of iterations for one right-hand side.
    pub(super) fn iterations(&self) -> usize {
        self.iterations
    }

    /// Returns `ridge^2 tr M^-2`, the degrees of freedom that a ridge leaves to the residuals.
    pub(super) fn ridge_freedom(&self) -> f64 {
        self.ridge * self.ridge * self.square_traces.iter().sum::<f64>()
    }

    /// Solves `M x = b` until the residual has the norm `tolerance`.
    pub(super) fn solve(
        &mut self,
        b: &Alm,
        tolerance: f64,
        watch: Watch<'_>,
    ) -> Result<SystemSolution, SolveError> {
        let mut system = System { matrix: &mut self.matrix, shift: self.ridge };
        let solution = system.solve(b, tolerance, LeastSquares::MAX_ITERATIONS, watch)?;
        self.iterations = self.iterations.max(solution.iterations);
        if let Some((smallest, largest)) = solution.eigenvalues {
            self.extremes = (self.extremes.0.min(smallest), self.extremes.1.max(largest));
        }
        Ok(solution)
    }

    /// Computes the traces; returns whether every system was solved.
    pub(super) fn estimate_traces(
        &mut self,
        n_harmonics: usize,
        watch: Watch<'_>,
    ) -> Result<bool, SolveError> {
        if n_harmonics <= MAX_EXACT {
            return self.compute_traces(watch);
        }
        let mut z = Alm::zeros(self.lmax())?;
        let mut image = z.clone();
        let mut signs = Signs(0);
        // The means over the vectors of z M z and z M^-1 z by degree, and of |M z|^2.
        let (mut forms, mut square) = (vec![0.0; self.traces.len()], 0.0);
        let mut inverse_forms = forms.clone();
        for count in 1..=MAX_VECTORS {
            signs.fill(self.domain, &mut z);
            let relative = TOLERANCE * (n_harmonics as f64).sqrt();
            let tolerance = if count == 1 { FIRST_TOLERANCE } else { relative };
            let solution = self.solve(&z, tolerance, watch)?;
            let is_solved = solution.residual <= tolerance;
            if !is_solved {
                return Ok(false);
            }
            self.matrix.apply(&z, &mut image);
            add(&mut image, self.ridge, &z);
            let share = 1.0 / count as f64;
            let mean = |means: &mut [f64], new: &[f64]| {
                means.iter_mut().zip(new).for_each(|(mean, new)| *mean += share * (new - *mean));
            };
            mean(&mut inverse_forms, &dot_per_degree(&z, &solution.x));
            mean(&mut forms, &dot_per_degree(&z, &image));
            mean(&mut self.square_traces, &solution.x.energy_per_degree());
            square += share * (dot(&image, &image) - square);
            let spread = Spread {
                mean: self.mean_eigenvalue(),
                square: square / n_harmonics as f64,
                inverse: inverse_forms.iter().sum::<f64>() / n_harmonics as f64,
                inverse_square: self.square_traces.iter().sum::<f64>() / n_harmonics as f64,
            };
            self.set_traces(&inverse_forms, &forms, &spread, share);
            if count >= MIN_VECTORS && share * spread.excess() <= TRACE_SHARE {
                break;
            }
        }
        Ok(true)
    }

    /// Sets the traces from the means of `z M^-1 z` and `z M z` over a number of vectors, of which
    /// `share` is the inverse.
    fn set_traces(&mut self, inverse_forms: &[f64], forms: &[f64], spread: &Spread, share: f64) {
        for (l, (inverse_form, form)) in inverse_forms.iter().zip(forms).enumerate() {
            let n = if self.domain.has_degree(l) { orders(l) } else { 0.0 };
            let error = spread.slope() * (form - n * spread.mean);
            // (M^-1)_ii >= 1/M_ii.
            self.traces[l] = (inverse_form - error).max(n / spread.mean);
            self.variances[l] = 2.0 * share * spread.excess() * n * spread.inverse.powi(2);
        }
    }

    /// Computes the traces of a small matrix from the columns of its inverse.
    fn compute_traces(&mut self, watch: Watch<'_>) -> Result<bool, SolveError> {
        const TOLERANCE: f64 = 1e-10;
        let mut unit = Alm::zeros(self.lmax())?;
        let domain = self.domain;
        for (l, m) in unit.index().iter().filter(|&(l, _)| domain.has_degree(l)) {
            // The real and the imaginary part of order m > 0 stand for m and -m.
            let parts = if m == 0 { &UNITS[..1] } else { &UNITS[1..] };
            for part in parts {
                unit[(l, m)] = *part;
                let solution = self.solve(&unit, TOLERANCE, watch)?;
                let is_solved = solution.residual <= TOLERANCE;
                if !is_solved {
                    return Ok(false);
                }
                self.traces[l] += dot_per_degree(&unit, &solution.x)[l];
                self.square_traces[l] += solution.x.energy_per_degree().iter().sum::<f64>();
            }
            unit[(l, m)] = Complex::ZERO;
        }
        Ok(true)
    }

    /// Returns the energy of the noise of degree `l` in fits of energy `fitted`, for noise of this
    /// variance, which is known from a number of degrees of freedom.
    pub(super) fn noise(&self, l: usize, variance: f64, freedom: f64, fitted: f64) -> NoiseEnergy {
        // C = M^-1 - ridge M^-2.
        let trace = self.traces[l] - self.ridge * self.square_traces[l];
        let mean = variance * trace.max(0.0);
        let of_order = mean / orders(l);
        let of_function = 4.0 * of_order * (fitted - mean).max(0.0);
        let of_noise = 2.0 * of_order * mean;
        let of_variance = 2.0 * mean * mean / freedom;
        let of_trace = variance * variance * self.variances[l];
        NoiseEnergy { mean, stderr: (of_function + of_noise + of_variance + of_trace).sqrt() }
    }

    fn lmax(&self) -> usize {
        self.traces.len() - 1
    }
}

/// The mean eigenvalue of M, and the means of its square, its inverse and the square of that.
struct Spread {
    mean: f64,
    square: f64,
    inverse: f64,
    inverse_square: f64,
}

impl Spread {
    /// Returns the slope of the regression of entries of `M^-1` off the diagonal on those of M.
    ///
    /// For eigenvectors in random directions the covariance of entries is proportional to that of
    /// eigenvalues, so the slope is `Cov(t, 1/t)/Var(t)`.
    fn slope(&self) -> f64 {
        let variance = self.square - self.mean * self.mean;
        // Below, the eigenvalues are equal up to rounding.
        let is_known = variance > 1e-12 * self.square;
        if is_known { (1.0 - self.mean * self.inverse) / variance } else { 0.0 }
    }

    /// Returns the variance of entries of `M^-1` off the diagonal about that regression, summed
    /// over a row, relative to the square of the diagonal.
    fn excess(&self) -> f64 {
        let variance = self.inverse_square - self.inverse * self.inverse;
        let explained = self.slope() * (1.0 - self.mean * self.inverse);
        ((variance - explained) / self.inverse.powi(2)).max(0.0)
    }
}

/// Coefficients of order 0 and of the others, of norm 1.
const UNITS: [Complex<f64>; 3] = [
    Complex { re: 1.0, im: 0.0 },
    Complex { re: FRAC_1_SQRT_2, im: 0.0 },
    Complex { re: 0.0, im: FRAC_1_SQRT_2 },
];

/// Returns the number of orders of a degree.
fn orders(l: usize) -> f64 {
    2.0 * l as f64 + 1.0
}

/// Returns the inner product of each degree of real functions.
fn dot_per_degree(a: &Alm, b: &Alm) -> Vec<f64> {
    let mut sums = vec![0.0; a.lmax() + 1];
    for m in 0..=a.lmax() {
        let weight = if m == 0 { 1.0 } else { 2.0 };
        for (sum, (a, b)) in sums[m..].iter_mut().zip(a.column(m).iter().zip(b.column(m))) {
            *sum += weight * (a.re * b.re + a.im * b.im);
        }
    }
    sums
}

/// Random signs by the generator `SplitMix64` (Steele, Lea and Flood 2014,
/// doi:10.1145/2714064.2660195).
struct Signs(u64);

impl Signs {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        if bits >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// Sets the coefficients of a real function to random signs, for orthonormal real harmonics.
    fn fill(&mut self, domain: Domain, z: &mut Alm) {
        for m in 0..=z.lmax() {
            for a in z.column_mut(m) {
                let (re, im) = (self.next(), self.next());
                *a = if m == 0 { re.into() } else { Complex::new(re, im) * FRAC_1_SQRT_2 };
            }
        }
        project(domain, z);
    }
}
