use std::f64::consts::TAU;
use std::fmt;

use num_complex::Complex;
use pulp::Arch;

use crate::coefficients::{ComplexTorusCoefficients, TorusCoefficients};
use crate::design::Design;
use crate::engine::{Engine, Scratch};
use crate::error::Error;
use crate::input;
use crate::limits::MAX_KMAX;
use crate::memory::resize;
use crate::real::Real;

/// Nonuniform Fourier transforms between scattered points on the torus and Fourier coefficients.
///
/// ```text
/// type 1    c(k1, k2) = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))     for |k1|, |k2| <= kmax
/// type 2    f(u, v) = sum_k c(k1, k2) exp(2 pi i (k1 u + k2 v))      over the same frequencies
/// ```
///
/// [`Self::adjoint`] is of type 1, [`Self::evaluate`] of type 2; each is the adjoint of the other.
/// Coordinates `(u, v)` in `[0, 1)^2` are in turns. Weights and functions are real, and weights default to
/// 1; [`Self::adjoint_complex`] and [`Self::evaluate_complex`] take complex ones. Input and
/// output are of type f32 or f64.
///
/// # Accuracy
///
/// The error of every coefficient is at most epsilon times the sum of the absolute weights, and the
/// error of every value at most epsilon times the sum of the absolute coefficients, c(k) and c(-k)
/// both counted. For weights of one sign, the Euclidean norm of the error over all coefficients is
/// also at most epsilon times the norm of the exact coefficients. Results in f32 are rounded to it.
///
/// # Performance
///
/// The cost is O(N log^2(1/epsilon) + kmax^2 log kmax), compared with O(N kmax^2) of
/// [`direct_adjoint`](crate::direct_adjoint) and [`direct_evaluate`](crate::direct_evaluate). The
/// grid has (2.5 to 5.6)^2 kmax^2 numbers, in f32 if `epsilon >= 5e-6`; its spectra have twice as
/// many for half of the frequencies. The transform uses one thread. Results are bit-identical for
/// the same input, independent of earlier calls.
///
/// # Examples
///
/// ```
/// use sphvar_nufft::{TorusTransform, direct_adjoint};
///
/// // A lattice of 5 x 5 points: only multiples of 5 remain, each with the sum of the weights.
/// let points: Vec<[f64; 2]> =
///     (0..25).map(|j| [f64::from(j % 5) / 5.0, f64::from(j / 5) / 5.0]).collect();
/// let transform = TorusTransform::new(12, 1e-9)?;
/// let c = transform.adjoint(&points, None)?;
/// assert!(c.get(10, -5).is_some_and(|c| (c - 25.0).norm() <= 25.0 * 1e-9));
/// assert!(c.get(3, 0).is_some_and(|c| c.norm() <= 25.0 * 1e-9));
///
/// // The same by the definition.
/// let exact = direct_adjoint(12, &points, None)?;
/// for (fast, exact) in c.values().iter().zip(exact.values()) {
///     assert!((fast - exact).norm() <= 25.0 * 1e-9);
/// }
///
/// // The series with these coefficients is 25^2 at the points of the lattice.
/// for value in transform.evaluate(&c, &points)? {
///     assert!((value - 625.0).abs() <= 25.0 * 25.0 * 25.0 * 1e-9);
/// }
/// # Ok::<(), sphvar_nufft::Error>(())
/// ```
///
/// # References
///
/// - Greengard and Lee 2004, doi:10.1137/S003614450343200X: the method.
/// - Barnett, Magland and af Klinteberg 2019, doi:10.1137/18M120885X: the window.
#[derive(Clone)]
pub struct TorusTransform {
    kmax: usize,
    epsilon: f64,
    engine: Precision,
}

#[derive(Clone)]
enum Precision {
    Single(Engine<f32>),
    Double(Engine<f64>),
}

/// Workspace of [`TorusTransform`]; grows to the largest input so far.
#[derive(Debug, Default)]
pub struct TorusWorkspace {
    single: Scratch<f32>,
    double: Scratch<f64>,
    /// The coefficients of the real and of the imaginary part of complex weights or functions.
    parts: [Vec<Complex<f64>>; 2],
}

/// Evaluates an expression with the engine of a plan and the workspace of its precision.
macro_rules! with_engine {
    ($plan:expr, $workspace:expr, |$engine:ident, $scratch:ident| $call:expr) => {
        match &$plan.engine {
            Precision::Single($engine) => {
                let $scratch = &mut $workspace.single;
                $call
            }
            Precision::Double($engine) => {
                let $scratch = &mut $workspace.double;
                $call
            }
        }
    };
}

impl fmt::Debug for TorusTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TorusTransform")
            .field("kmax", &self.kmax)
            .field("epsilon", &self.epsilon)
            .finish_non_exhaustive()
    }
}

impl TorusTransform {
    /// Returns the plan for frequencies up to `kmax`, inclusive, and accuracy `epsilon` in [1e-13,
    /// 1e-1].
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if `epsilon` is NaN or out of range; [`Error::FrequencyTooLarge`] if
    /// `kmax` exceeds [`MAX_KMAX`].
    pub fn new(kmax: usize, epsilon: f64) -> Result<Self, Error> {
        Self::with_arch(kmax, epsilon, Arch::new())
    }

    /// Returns the plan with the arithmetic of another instruction set, for tests.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    #[doc(hidden)]
    pub fn with_arch(kmax: usize, epsilon: f64, arch: Arch) -> Result<Self, Error> {
        let design = Design::at_every_frequency(epsilon)?;
        if kmax > MAX_KMAX {
            return Err(Error::FrequencyTooLarge { kmax, max: MAX_KMAX });
        }
        let engine = if design.single {
            Precision::Single(Engine::new(kmax, design, arch))
        } else {
            Precision::Double(Engine::new(kmax, design, arch))
        };
        Ok(Self { kmax, epsilon, engine })
    }

    /// Returns the maximum frequency, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.kmax
    }

    fn check_kmax(&self, got: usize) -> Result<(), Error> {
        if got == self.kmax {
            Ok(())
        } else {
            Err(Error::KmaxMismatch { expected: self.kmax, got })
        }
    }
}

/// Type 1, from points to coefficients.
impl TorusTransform {
    /// Returns the coefficients of the points; `weights` of `None` means unit weights.
    ///
    /// # Errors
    ///
    /// - [`Error::Point`] if a coordinate is NaN or outside `[0, 1)`,
    /// - [`Error::WeightCount`] if weights and points differ in number,
    /// - [`Error::Weight`] if a weight is not finite,
    /// - [`Error::Overflow`] if the sum of the absolute weights is not finite,
    /// - [`Error::TooManyPoints`] for 2^32 or more points,
    /// - [`Error::OutOfMemory`] if allocation of grids or coefficients fails.
    pub fn adjoint<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: Option<&[R]>,
    ) -> Result<TorusCoefficients<R>, Error> {
        let mut out = TorusCoefficients::zeros(self.kmax)?;
        self.adjoint_into(points, weights, &mut TorusWorkspace::default(), &mut out)?;
        Ok(out)
    }

    /// Replaces `out` by the coefficients of the points; `weights` of `None` means unit weights. On
    /// error `out` is unchanged.
    ///
    /// Does not allocate if the workspace has been used for inputs of this size.
    ///
    /// # Errors
    ///
    /// As for [`Self::adjoint`], and [`Error::KmaxMismatch`] if `out` has a different kmax.
    pub fn adjoint_into<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: Option<&[R]>,
        workspace: &mut TorusWorkspace,
        out: &mut TorusCoefficients<R>,
    ) -> Result<(), Error> {
        R::torus_adjoint(self, points, weights, workspace, out)
    }

    pub(crate) fn adjoint_body<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: Option<&[R]>,
        workspace: &mut TorusWorkspace,
        out: &mut TorusCoefficients<R>,
    ) -> Result<(), Error> {
        input::check(points, weights)?;
        self.check_kmax(out.kmax())?;
        let values = out.values_mut();
        with_engine!(self, workspace, |engine, scratch| engine
            .adjoint(points, weights, scratch, values))
    }

    /// Replaces `outs` by the coefficients of the same points with several vectors of weights.
    ///
    /// # Errors
    ///
    /// As for [`Self::adjoint_into`], and [`Error::BatchSize`] if the numbers of weight vectors and
    /// outputs differ.
    ///
    /// # Performance
    ///
    /// Pairs of vectors share the sorted points and their window values, and use two grids.
    pub fn adjoint_batch_into<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: &[&[R]],
        workspace: &mut TorusWorkspace,
        outs: &mut [TorusCoefficients<R>],
    ) -> Result<(), Error> {
        R::torus_adjoint_batch(self, points, weights, workspace, outs)
    }

    pub(crate) fn adjoint_batch_body<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: &[&[R]],
        workspace: &mut TorusWorkspace,
        outs: &mut [TorusCoefficients<R>],
    ) -> Result<(), Error> {
        if weights.len() != outs.len() {
            return Err(Error::BatchSize { inputs: weights.len(), outputs: outs.len() });
        }
        for (weights, out) in weights.iter().zip(&*outs) {
            input::check(points, Some(weights))?;
            self.check_kmax(out.kmax())?;
        }
        for (weights, outs) in weights.chunks(2).zip(outs.chunks_mut(2)) {
            match outs {
                [one, other] => {
                    let weight = |j: usize, b: usize| weights[b][j].to_f64();
                    let outs = [one.values_mut(), other.values_mut()];
                    with_engine!(self, workspace, |engine, scratch| engine
                        .adjoint_pair(points, weight, scratch, outs))?;
                }
                outs => {
                    for (weights, out) in weights.iter().zip(outs) {
                        self.adjoint_into(points, Some(weights), workspace, out)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the coefficients of points with complex weights.
    ///
    /// # Errors
    ///
    /// As for [`Self::adjoint`]; a weight has a modulus of at most the sum of the absolute values of
    /// its parts, which replaces the absolute weight for [`Error::Overflow`].
    pub fn adjoint_complex<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: &[Complex<R>],
    ) -> Result<ComplexTorusCoefficients<R>, Error> {
        let mut out = ComplexTorusCoefficients::zeros(self.kmax)?;
        self.adjoint_complex_into(points, weights, &mut TorusWorkspace::default(), &mut out)?;
        Ok(out)
    }

    /// Replaces `out` by the coefficients of points with complex weights. On error `out` is
    /// unchanged.
    ///
    /// # Errors
    ///
    /// As for [`Self::adjoint_complex`], and [`Error::KmaxMismatch`] if `out` has a different kmax.
    pub fn adjoint_complex_into<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: &[Complex<R>],
        workspace: &mut TorusWorkspace,
        out: &mut ComplexTorusCoefficients<R>,
    ) -> Result<(), Error> {
        R::torus_adjoint_complex(self, points, weights, workspace, out)
    }

    pub(crate) fn adjoint_complex_body<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: &[Complex<R>],
        workspace: &mut TorusWorkspace,
        out: &mut ComplexTorusCoefficients<R>,
    ) -> Result<(), Error> {
        input::check_complex(points, weights)?;
        self.check_kmax(out.kmax())?;
        let mut parts = workspace.take_parts(self.kmax)?;
        let [re, im] = &mut parts;
        let weight = |j: usize, b: usize| [weights[j].re, weights[j].im][b].to_f64();
        let outs = [&mut **re, &mut **im];
        let result = with_engine!(self, workspace, |engine, scratch| engine
            .adjoint_pair(points, weight, scratch, outs));
        if result.is_ok() {
            out.set_parts([&parts[0], &parts[1]]);
        }
        workspace.parts = parts;
        result
    }
}

/// Type 2, from coefficients to values at points.
impl TorusTransform {
    /// Returns the values at the points of the real function with these coefficients: the real part
    /// of the series, if callers have changed `c(k1, 0)` without `c(-k1, 0)`.
    ///
    /// # Errors
    ///
    /// - [`Error::KmaxMismatch`] if the coefficients have a different kmax,
    /// - [`Error::Coefficient`] if a coefficient is not finite,
    /// - [`Error::Overflow`] if the sum of the absolute coefficients is not finite,
    /// - [`Error::Point`], [`Error::TooManyPoints`] and [`Error::OutOfMemory`] as for
    ///   [`Self::adjoint`].
    pub fn evaluate<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        points: &[[R; 2]],
    ) -> Result<Vec<R>, Error> {
        let mut values = Vec::new();
        resize(&mut values, points.len())?;
        self.evaluate_into(coefficients, points, &mut TorusWorkspace::default(), &mut values)?;
        Ok(values)
    }

    /// Writes the values of [`Self::evaluate`]. On error `values` is unchanged.
    ///
    /// # Errors
    ///
    /// As for [`Self::evaluate`], and [`Error::ValueCount`] if values and points differ in number.
    pub fn evaluate_into<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [R],
    ) -> Result<(), Error> {
        self.evaluate_batch_into(&[coefficients], points, workspace, values)
    }

    /// Writes the values of several functions at the same points: function b of `n_functions` at
    /// point j to `values[j * n_functions + b]`. On error `values` is unchanged.
    ///
    /// # Errors
    ///
    /// As for [`Self::evaluate`], and [`Error::ValueCount`] if there is not one value for each
    /// function and point.
    ///
    /// # Performance
    ///
    /// Functions share the sorted points and their window values; each has a grid.
    pub fn evaluate_batch_into<R: Real>(
        &self,
        coefficients: &[&TorusCoefficients<R>],
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [R],
    ) -> Result<(), Error> {
        R::torus_evaluate_batch(self, coefficients, points, workspace, values)
    }

    pub(crate) fn evaluate_batch_body<R: Real>(
        &self,
        coefficients: &[&TorusCoefficients<R>],
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [R],
    ) -> Result<(), Error> {
        for coefficients in coefficients {
            self.check_series(coefficients, 1.0)?;
        }
        input::check::<R>(points, None)?;
        input::check_values(points.len().saturating_mul(coefficients.len()), values.len())?;
        let series: Vec<&[Complex<R>]> = coefficients.iter().map(|c| c.values()).collect();
        with_engine!(self, workspace, |engine, scratch| engine
            .evaluate(&series, points, scratch, values))
    }

    /// Returns `[f, df/du, df/dv]` at the points, for the real function f of [`Self::evaluate`].
    /// Derivatives are per turn.
    ///
    /// The error of a derivative is at most `8 pi max(kmax + 1, 10) max(epsilon, 1e-12)` times the
    /// sum of the absolute coefficients: the errors of the window have higher frequencies, up to
    /// that of the grid, and derivatives amplify them.
    ///
    /// # Errors
    ///
    /// As for [`Self::evaluate`]; for [`Error::Overflow`] coefficients are multiplied by `2 pi
    /// (kmax + 1)`.
    ///
    /// # Performance
    ///
    /// Value and derivatives share the grid: the derivative of a window's polynomials is that of the
    /// function. The cost is that of [`Self::evaluate`] and at most twice its cost per point.
    pub fn gradient<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        points: &[[R; 2]],
    ) -> Result<Vec<[R; 3]>, Error> {
        let mut values = Vec::new();
        resize(&mut values, points.len())?;
        self.gradient_into(coefficients, points, &mut TorusWorkspace::default(), &mut values)?;
        Ok(values)
    }

    /// Writes the values of [`Self::gradient`]. On error `values` is unchanged.
    ///
    /// # Errors
    ///
    /// As for [`Self::gradient`], and [`Error::ValueCount`] if values and points differ in number.
    pub fn gradient_into<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [[R; 3]],
    ) -> Result<(), Error> {
        R::torus_gradient(self, coefficients, points, workspace, values)
    }

    pub(crate) fn gradient_body<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [[R; 3]],
    ) -> Result<(), Error> {
        self.check_series(coefficients, TAU * (self.kmax as f64 + 1.0))?;
        input::check::<R>(points, None)?;
        input::check_values(points.len(), values.len())?;
        with_engine!(self, workspace, |engine, scratch| engine.gradient(
            coefficients.values(),
            points,
            scratch,
            values
        ))
    }

    /// Returns the values at the points of the complex function with these coefficients.
    ///
    /// # Errors
    ///
    /// As for [`Self::evaluate`].
    pub fn evaluate_complex<R: Real>(
        &self,
        coefficients: &ComplexTorusCoefficients<R>,
        points: &[[R; 2]],
    ) -> Result<Vec<Complex<R>>, Error> {
        let mut values = Vec::new();
        resize(&mut values, points.len())?;
        let workspace = &mut TorusWorkspace::default();
        self.evaluate_complex_into(coefficients, points, workspace, &mut values)?;
        Ok(values)
    }

    /// Writes the values of [`Self::evaluate_complex`]. On error `values` is unchanged.
    ///
    /// # Errors
    ///
    /// As for [`Self::evaluate_complex`], and [`Error::ValueCount`] if values and points differ in
    /// number.
    pub fn evaluate_complex_into<R: Real>(
        &self,
        coefficients: &ComplexTorusCoefficients<R>,
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [Complex<R>],
    ) -> Result<(), Error> {
        R::torus_evaluate_complex(self, coefficients, points, workspace, values)
    }

    pub(crate) fn evaluate_complex_body<R: Real>(
        &self,
        coefficients: &ComplexTorusCoefficients<R>,
        points: &[[R; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [Complex<R>],
    ) -> Result<(), Error> {
        self.check_kmax(coefficients.kmax())?;
        input::check_coefficients(coefficients.values(), 1.0)?;
        input::check::<R>(points, None)?;
        input::check_values(points.len(), values.len())?;
        let mut parts = workspace.take_parts(self.kmax)?;
        let [re, im] = &mut parts;
        coefficients.split_into([re, im]);
        let mut interleaved = Vec::new();
        let result = resize(&mut interleaved, 2 * points.len()).and_then(|()| {
            let series = [&**re, &**im];
            with_engine!(self, workspace, |engine, scratch| engine.evaluate(
                &series,
                points,
                scratch,
                &mut interleaved
            ))
        });
        if result.is_ok() {
            for (value, [re, im]) in values.iter_mut().zip(interleaved.as_chunks::<2>().0) {
                *value = Complex { re: *re, im: *im };
            }
        }
        workspace.parts = parts;
        result
    }

    fn check_series<R: Real>(
        &self,
        coefficients: &TorusCoefficients<R>,
        factor: f64,
    ) -> Result<(), Error> {
        self.check_kmax(coefficients.kmax())?;
        // Each value stands for c(k) and c(-k).
        input::check_coefficients(coefficients.values(), 2.0 * factor)
    }
}

impl TorusWorkspace {
    /// Takes the parts, with the length of [`TorusCoefficients::values`].
    fn take_parts(&mut self, kmax: usize) -> Result<[Vec<Complex<f64>>; 2], Error> {
        for part in &mut self.parts {
            resize(part, (2 * kmax + 1) * (kmax + 1))?;
        }
        Ok(std::mem::take(&mut self.parts))
    }
}
