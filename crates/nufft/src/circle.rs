use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};
use rustfft::{Fft, FftDirection};

use crate::cells::{LANES, Locator, Turns};
use crate::design::Design;
use crate::error::Error;
use crate::fourier::fold_row;
use crate::input;
use crate::limits::MAX_CIRCLE_KMAX;
use crate::long_sum::add_with_rests;
use crate::magnitude::magnitude_of;
use crate::memory::resize;
use crate::real::Real;
use crate::spreading::{ByWidth, for_width};
use crate::window::{MAX_WIDTH, WindowTable};

/// Nonuniform Fourier transform of type 1 on the circle, from scattered coordinates to coefficients.
///
/// ```text
/// c(k) = sum_j w_j exp(-2 pi i k u_j)     for 0 <= k <= kmax
/// ```
///
/// Coordinates u in `[0, 1)` are in turns. Weights are real and default to 1; `c(-k)` is the
/// complex conjugate of `c(k)`. These are the coefficients of points of the torus along an axis, to
/// much higher frequencies than a grid in two dimensions permits.
///
/// # Accuracy
///
/// The error of every coefficient is at most epsilon times the sum of the absolute weights.
///
/// # Performance
///
/// The cost is O(N log(1/epsilon) + kmax log kmax). The transform uses one thread, and its grid has
/// 2.5 to 5.6 kmax numbers. Results are bit-identical for the same input, independent of earlier
/// calls.
///
/// # Examples
///
/// ```
/// use sphvar_nufft::CircleTransform;
///
/// // Four points at multiples of a quarter: only multiples of 4 remain.
/// let c = CircleTransform::new(1000, 1e-12)?.adjoint(&[0.0, 0.25, 0.5, 0.75], None)?;
/// assert!((c[1000] - 4.0).norm() < 4e-12 && c[999].norm() < 4e-12);
/// # Ok::<(), sphvar_nufft::Error>(())
/// ```
#[derive(Clone)]
pub struct CircleTransform {
    kmax: usize,
    epsilon: f64,
    arch: Arch,
    locator: Locator,
    table: WindowTable<f64>,
    /// The reciprocal of the window's transform at each k.
    correction: Box<[f64]>,
    /// `exp(-2 pi i k/n)` for a grid of n cells.
    twiddles: Box<[Complex<f64>]>,
    /// Of length n/2.
    fft: Arc<dyn Fft<f64>>,
}

/// Workspace of [`CircleTransform`]; grows to the largest input so far.
#[derive(Debug, Default)]
pub struct CircleWorkspace {
    grid: Vec<f64>,
    /// The rounding errors of the sums on the grid.
    rests: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    fft: Vec<Complex<f64>>,
}

impl fmt::Debug for CircleTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CircleTransform")
            .field("kmax", &self.kmax)
            .field("epsilon", &self.epsilon)
            .finish_non_exhaustive()
    }
}

impl CircleTransform {
    /// Returns the plan for frequencies up to `kmax`, inclusive, and accuracy `epsilon` in [1e-13,
    /// 1e-1].
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if `epsilon` is NaN or out of range; [`Error::FrequencyTooLarge`] if
    /// `kmax` exceeds [`MAX_CIRCLE_KMAX`].
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
        let design = Design::double_at_every_frequency(epsilon)?;
        if kmax > MAX_CIRCLE_KMAX {
            return Err(Error::FrequencyTooLarge { kmax, max: MAX_CIRCLE_KMAX });
        }
        let n = design.cells(kmax);
        let twiddle = |k: usize| Complex::from_polar(1.0, -TAU * (k as f64 / n as f64));
        let table = design.window.table();
        Ok(Self {
            kmax,
            epsilon,
            arch,
            locator: Locator::new([n; 2], 1, &table),
            table,
            correction: design.window.transform(n, kmax).into_iter().map(f64::recip).collect(),
            twiddles: (0..=kmax).map(twiddle).collect(),
            fft: f64::fourier_plan(n / 2, FftDirection::Forward),
        })
    }

    /// Returns the maximum frequency, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.kmax
    }

    /// Returns `c(k)` for k from 0 to kmax; `weights` of `None` means unit weights.
    ///
    /// # Errors
    ///
    /// - [`Error::Coordinate`] if a coordinate is NaN or outside `[0, 1)`,
    /// - [`Error::WeightCount`] if weights and points differ in number,
    /// - [`Error::Weight`] if a weight is not finite,
    /// - [`Error::Overflow`] if the sum of the absolute weights is not finite,
    /// - [`Error::TooManyPoints`] for 2^32 or more points,
    /// - [`Error::OutOfMemory`] if allocation fails.
    pub fn adjoint<R: Real>(
        &self,
        points: &[R],
        weights: Option<&[R]>,
    ) -> Result<Vec<Complex<R>>, Error> {
        let mut out = Vec::new();
        resize(&mut out, self.kmax + 1)?;
        self.adjoint_into(points, weights, &mut CircleWorkspace::default(), &mut out)?;
        Ok(out)
    }

    /// Replaces `out` by `c(k)` for k from 0 to kmax; `weights` of `None` means unit weights. On
    /// error `out` is unchanged.
    ///
    /// Does not allocate if the workspace has been used for a transform of this size.
    ///
    /// # Errors
    ///
    /// As for [`Self::adjoint`], and [`Error::ValueCount`] if `out` does not have kmax + 1 entries.
    pub fn adjoint_into<R: Real>(
        &self,
        points: &[R],
        weights: Option<&[R]>,
        workspace: &mut CircleWorkspace,
        out: &mut [Complex<R>],
    ) -> Result<(), Error> {
        R::circle_adjoint(self, points, weights, workspace, out)
    }

    pub(crate) fn adjoint_body<R: Real>(
        &self,
        points: &[R],
        weights: Option<&[R]>,
        workspace: &mut CircleWorkspace,
        out: &mut [Complex<R>],
    ) -> Result<(), Error> {
        input::check_circle(points, weights)?;
        if out.len() != self.kmax + 1 {
            return Err(Error::ValueCount { expected: self.kmax + 1, got: out.len() });
        }
        let n = self.locator.cells[1];
        let len = n + self.locator.margin + MAX_WIDTH;
        let CircleWorkspace { grid, rests, spectrum, fft } = workspace;
        for values in [&mut *grid, rests] {
            values.clear();
            resize(values, len)?;
        }
        resize(spectrum, n / 2 + 1)?;
        resize(fft, self.fft.get_inplace_scratch_len())?;
        let size = weights.map_or(1.0, magnitude_of);
        let scale = 1.0 / size;
        self.arch.dispatch(Spread { transform: self, points, weights, scale, grid, rests });
        for (sum, rest) in grid.iter_mut().zip(&*rests) {
            *sum += rest;
        }
        fold_row(grid, n, self.locator.margin);
        let body = &grid[self.locator.margin..][..n];
        // A transform of half the length: even cells are real parts and odd cells imaginary parts.
        let half = n / 2;
        for (z, [even, odd]) in spectrum.iter_mut().zip(body.as_chunks::<2>().0) {
            *z = Complex::new(*even, *odd);
        }
        self.fft.process_with_scratch(&mut spectrum[..half], &mut fft[..]);
        spectrum[half] = spectrum[0];
        let factors = self.correction.iter().zip(&self.twiddles);
        for (k, (out, (correction, twiddle))) in out.iter_mut().zip(factors).enumerate() {
            let (here, there) = (spectrum[k], spectrum[half - k].conj());
            let (even, odd) = ((here + there) * 0.5, (here - there) * 0.5);
            // odd is i times the transform of the odd cells.
            let value = even + Complex::new(odd.im, -odd.re) * twiddle;
            let value = value * *correction * size;
            *out = Complex::new(R::of(value.re), R::of(value.im));
        }
        Ok(())
    }
}

/// Adds the points to the grid in compensated sums, for any number of points at one place.
struct Spread<'a, R> {
    transform: &'a CircleTransform,
    points: &'a [R],
    weights: Option<&'a [R]>,
    scale: f64,
    grid: &'a mut [f64],
    rests: &'a mut [f64],
}

impl<R: Real> WithSimd for Spread<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let padded = self.transform.table.padded();
        for_width::<S, _>(padded, self);
    }
}

impl<R: Real> ByWidth for Spread<'_, R> {
    #[inline(always)]
    fn run<const P: usize, const H: usize, const FUSED: bool>(self) {
        let Self { transform, points, weights, scale, grid, rests } = self;
        let CircleTransform { locator, table, .. } = transform;
        for (chunk, points) in points.chunks(LANES).enumerate() {
            let mut turns = Turns::default();
            for (i, u) in points.iter().enumerate() {
                turns.set(i, u.to_f64());
            }
            // Positions on grids of 10^5 cells need the fused operation on every machine.
            let (first, t) = locator.windows::<true>(&turns, locator.cells[1]);
            let weights = weights.map(|w| &w[chunk * LANES..]);
            for pair in (0..points.len()).step_by(2) {
                let windows = table.evaluate::<P, H, FUSED>([t[pair], t[pair + 1]]);
                for (i, window) in (pair..points.len()).zip(&windows) {
                    let weight = weights.map_or(scale, |w| w[i].to_f64() * scale);
                    let terms = window.map(|value| value * weight);
                    let place = first[i] as usize - table.pad();
                    add_with_rests(&mut grid[place..][..P], &mut rests[place..][..P], &terms);
                }
            }
        }
    }
}
