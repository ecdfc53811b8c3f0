use std::fmt;

use num_complex::Complex;
use pulp::Arch;

use crate::cells::{Cells, LANES, Places, Turns};
use crate::coefficients::TorusCoefficients;
use crate::design::Design;
use crate::error::Error;
use crate::fourier::{Fourier, FourierScratch};
use crate::input;
use crate::limits::MAX_KMAX;
use crate::magnitude::magnitude;
use crate::memory::resize;
use crate::real::Real;
use crate::spreading::Spreading;

/// Nonuniform Fourier transform of type 1, from scattered points on the torus to coefficients: the
/// adjoint of the evaluation of a Fourier series.
///
/// ```text
/// c(k1, k2) = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))     for |k1|, |k2| <= kmax
/// ```
///
/// Coordinates `(u, v)` in `[0, 1)^2` are in turns. Weights are real and default to 1.
///
/// # Accuracy
///
/// The error of every coefficient is at most epsilon times the sum of the absolute weights. For
/// weights of one sign, the Euclidean norm of the error over all coefficients is also at most
/// epsilon times the norm of the exact coefficients.
///
/// # Performance
///
/// The cost is O(N log^2(1/epsilon) + kmax^2 log kmax), compared with O(N kmax^2) of
/// [`direct_adjoint`](crate::direct_adjoint). The grid has (2.5 to 5.6)^2 kmax^2 numbers, in f32 if
/// `epsilon >= 5e-6`; its spectra have twice as many for half of the frequencies. The transform
/// uses one thread. Results are bit-identical for the same input, independent of earlier calls.
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

#[derive(Clone)]
struct Engine<T> {
    arch: Arch,
    spreading: Spreading<T>,
    fourier: Fourier<T>,
}

/// Workspace of [`TorusTransform`]; grows to the largest input so far.
#[derive(Debug, Default)]
pub struct TorusWorkspace {
    single: Scratch<f32>,
    double: Scratch<f64>,
}

#[derive(Debug, Default)]
struct Scratch<T> {
    cells: Cells<T>,
    grid: Vec<T>,
    fourier: FourierScratch<T>,
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

    fn with_arch(kmax: usize, epsilon: f64, arch: Arch) -> Result<Self, Error> {
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
    pub fn adjoint(
        &self,
        points: &[[f64; 2]],
        weights: Option<&[f64]>,
    ) -> Result<TorusCoefficients, Error> {
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
    /// As for [`Self::adjoint`], and [`Error::OutputSize`] if `out` has a different kmax.
    pub fn adjoint_into(
        &self,
        points: &[[f64; 2]],
        weights: Option<&[f64]>,
        workspace: &mut TorusWorkspace,
        out: &mut TorusCoefficients,
    ) -> Result<(), Error> {
        input::check(points, weights)?;
        if out.kmax() != self.kmax {
            return Err(Error::OutputSize { expected: self.kmax, got: out.kmax() });
        }
        let values = out.values_mut();
        match &self.engine {
            Precision::Single(engine) => {
                engine.adjoint(points, weights, &mut workspace.single, values)
            }
            Precision::Double(engine) => {
                engine.adjoint(points, weights, &mut workspace.double, values)
            }
        }
    }
}

impl<T: Real> Engine<T> {
    fn new(kmax: usize, design: Design, arch: Arch) -> Self {
        let cells = design.cells(kmax);
        let spreading = Spreading::new([cells; 2], cells, design.window, design.epsilon);
        Self { arch, spreading, fourier: Fourier::new(kmax, cells, design.window) }
    }

    fn adjoint(
        &self,
        points: &[[f64; 2]],
        weights: Option<&[f64]>,
        scratch: &mut Scratch<T>,
        out: &mut [Complex<f64>],
    ) -> Result<(), Error> {
        let Scratch { cells, grid, fourier } = scratch;
        cells.reserve(points.len())?;
        resize(fourier.spectra(), self.fourier.spectra_len())?;
        grid.clear();
        resize(grid, self.spreading.grid_len())?;
        let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
        self.spreading.locate(self.arch, &Points(points), weights, 1.0 / size, cells);
        self.spreading.spread(self.arch, cells, grid);
        self.fourier.run(self.arch, grid, &self.spreading, size, fourier, out);
        Ok(())
    }
}

/// Points given in turns.
struct Points<'a>(&'a [[f64; 2]]);

impl Places for Points<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn turns<const FUSED: bool>(&self, first: usize) -> [Turns; 2] {
        let mut turns = [Turns::default(); 2];
        for (i, point) in self.0[first..].iter().take(LANES).enumerate() {
            for (turns, &x) in turns.iter_mut().zip(point) {
                turns.set(i, x);
            }
        }
        turns
    }
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::TorusTransform;
    use crate::direct::direct_adjoint;

    #[test]
    fn the_portable_code_meets_the_requested_accuracy() {
        let points: Vec<[f64; 2]> = (0..200)
            .map(|j| [0.754877 * f64::from(j), 0.569840 * f64::from(j)].map(f64::fract))
            .collect();
        let exact = direct_adjoint(9, &points, None).unwrap();
        for epsilon in [1e-1, 1e-4, 1e-6, 1e-9, 1e-13] {
            let plan = TorusTransform::with_arch(9, epsilon, Arch::Scalar).unwrap();
            let fast = plan.adjoint(&points, None).unwrap();
            for (fast, exact) in fast.values().iter().zip(exact.values()) {
                assert!((fast - exact).norm() <= epsilon * 200.0, "{epsilon:e}: {fast}, {exact}");
            }
        }
    }
}
