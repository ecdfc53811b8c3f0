use std::ops::AddAssign;
use std::sync::Arc;

use num_complex::Complex;
use pulp::Arch;
use rustfft::{Fft, FftDirection, FftNum, FftPlanner};

use crate::cells::Cells;
use crate::circle::{CircleTransform, CircleWorkspace};
use crate::coefficients::{ComplexTorusCoefficients, TorusCoefficients};
use crate::error::Error;
use crate::spreading::Spreading;
use crate::threads::Threads;
use crate::transform::{TorusTransform, TorusWorkspace};

/// Number type of a grid: f32 if the requested accuracy permits, otherwise f64.
///
/// Optimized builds compile a generic function again in every crate that calls it. The public
/// functions with kernels for all widths of windows and instruction sets therefore call methods of
/// this trait, which are compiled once for each type, in this crate.
pub trait Real: FftNum + Default + AddAssign {
    /// The distance from 1 to the next larger number.
    const EPSILON: f64;
    /// The number of lanes of a 256-bit register.
    const LANES: usize;

    /// Returns the nearest number of this type.
    fn of(x: f64) -> Self;
    /// Returns the same number in f64.
    fn to_f64(self) -> f64;
    /// Returns the plan of one-dimensional Fourier transforms of a length.
    ///
    /// rustfft is generic over the number type and takes half a minute to compile for one.
    /// Planning here, and not where a plan is used, compiles it once for all crates.
    fn fourier_plan(length: usize, direction: FftDirection) -> Arc<dyn Fft<Self>>;
    /// Returns `self * a + b`, rounded once if `FUSED`, which is slow without hardware support.
    fn times_plus<const FUSED: bool>(self, a: Self, b: Self) -> Self;

    /// Computes [`TorusTransform::adjoint_into`].
    #[doc(hidden)]
    fn torus_adjoint(
        plan: &TorusTransform,
        points: &[[Self; 2]],
        weights: Option<&[Self]>,
        workspace: &mut TorusWorkspace,
        out: &mut TorusCoefficients<Self>,
    ) -> Result<(), Error>;

    /// Computes [`TorusTransform::adjoint_batch_into`].
    #[doc(hidden)]
    fn torus_adjoint_batch(
        plan: &TorusTransform,
        points: &[[Self; 2]],
        weights: &[&[Self]],
        workspace: &mut TorusWorkspace,
        outs: &mut [TorusCoefficients<Self>],
    ) -> Result<(), Error>;

    /// Computes [`TorusTransform::adjoint_complex_into`].
    #[doc(hidden)]
    fn torus_adjoint_complex(
        plan: &TorusTransform,
        points: &[[Self; 2]],
        weights: &[Complex<Self>],
        workspace: &mut TorusWorkspace,
        out: &mut ComplexTorusCoefficients<Self>,
    ) -> Result<(), Error>;

    /// Computes [`TorusTransform::evaluate_batch_into`].
    #[doc(hidden)]
    fn torus_evaluate_batch(
        plan: &TorusTransform,
        coefficients: &[&TorusCoefficients<Self>],
        points: &[[Self; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [Self],
    ) -> Result<(), Error>;

    /// Computes [`TorusTransform::gradient_into`].
    #[doc(hidden)]
    fn torus_gradient(
        plan: &TorusTransform,
        coefficients: &TorusCoefficients<Self>,
        points: &[[Self; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [[Self; 3]],
    ) -> Result<(), Error>;

    /// Computes [`TorusTransform::evaluate_complex_into`].
    #[doc(hidden)]
    fn torus_evaluate_complex(
        plan: &TorusTransform,
        coefficients: &ComplexTorusCoefficients<Self>,
        points: &[[Self; 2]],
        workspace: &mut TorusWorkspace,
        values: &mut [Complex<Self>],
    ) -> Result<(), Error>;

    /// Computes [`CircleTransform::adjoint_into`].
    #[doc(hidden)]
    fn circle_adjoint(
        plan: &CircleTransform,
        points: &[Self],
        weights: Option<&[Self]>,
        workspace: &mut CircleWorkspace,
        out: &mut [Complex<Self>],
    ) -> Result<(), Error>;

    /// Computes [`Spreading::spread`].
    #[doc(hidden)]
    fn spread(
        spreading: &Spreading<Self>,
        arch: Arch,
        cells: &Cells<Self>,
        threads: Threads,
        grid: &mut [Self],
    );

    /// Computes [`Spreading::interpolate`].
    #[doc(hidden)]
    fn interpolate(
        spreading: &Spreading<Self>,
        arch: Arch,
        cells: &Cells<Self>,
        grids: &[Self],
        sizes: &[f64],
        threads: Threads,
        out: &mut [f64],
    );
}

/// Defines the methods that other crates call instead of generic functions.
macro_rules! compile_here {
    () => {
        #[inline(never)]
        fn torus_adjoint(
            plan: &TorusTransform,
            points: &[[Self; 2]],
            weights: Option<&[Self]>,
            workspace: &mut TorusWorkspace,
            out: &mut TorusCoefficients<Self>,
        ) -> Result<(), Error> {
            plan.adjoint_body(points, weights, workspace, out)
        }

        #[inline(never)]
        fn torus_adjoint_batch(
            plan: &TorusTransform,
            points: &[[Self; 2]],
            weights: &[&[Self]],
            workspace: &mut TorusWorkspace,
            outs: &mut [TorusCoefficients<Self>],
        ) -> Result<(), Error> {
            plan.adjoint_batch_body(points, weights, workspace, outs)
        }

        #[inline(never)]
        fn torus_adjoint_complex(
            plan: &TorusTransform,
            points: &[[Self; 2]],
            weights: &[Complex<Self>],
            workspace: &mut TorusWorkspace,
            out: &mut ComplexTorusCoefficients<Self>,
        ) -> Result<(), Error> {
            plan.adjoint_complex_body(points, weights, workspace, out)
        }

        #[inline(never)]
        fn torus_evaluate_batch(
            plan: &TorusTransform,
            coefficients: &[&TorusCoefficients<Self>],
            points: &[[Self; 2]],
            workspace: &mut TorusWorkspace,
            values: &mut [Self],
        ) -> Result<(), Error> {
            plan.evaluate_batch_body(coefficients, points, workspace, values)
        }

        #[inline(never)]
        fn torus_gradient(
            plan: &TorusTransform,
            coefficients: &TorusCoefficients<Self>,
            points: &[[Self; 2]],
            workspace: &mut TorusWorkspace,
            values: &mut [[Self; 3]],
        ) -> Result<(), Error> {
            plan.gradient_body(coefficients, points, workspace, values)
        }

        #[inline(never)]
        fn torus_evaluate_complex(
            plan: &TorusTransform,
            coefficients: &ComplexTorusCoefficients<Self>,
            points: &[[Self; 2]],
            workspace: &mut TorusWorkspace,
            values: &mut [Complex<Self>],
        ) -> Result<(), Error> {
            plan.evaluate_complex_body(coefficients, points, workspace, values)
        }

        #[inline(never)]
        fn circle_adjoint(
            plan: &CircleTransform,
            points: &[Self],
            weights: Option<&[Self]>,
            workspace: &mut CircleWorkspace,
            out: &mut [Complex<Self>],
        ) -> Result<(), Error> {
            plan.adjoint_body(points, weights, workspace, out)
        }

        #[inline(never)]
        fn spread(
            spreading: &Spreading<Self>,
            arch: Arch,
            cells: &Cells<Self>,
            threads: Threads,
            grid: &mut [Self],
        ) {
            spreading.spread_together(arch, cells, None, threads, [grid]);
        }

        #[inline(never)]
        fn interpolate(
            spreading: &Spreading<Self>,
            arch: Arch,
            cells: &Cells<Self>,
            grids: &[Self],
            sizes: &[f64],
            threads: Threads,
            out: &mut [f64],
        ) {
            spreading.interpolate_body(arch, cells, grids, sizes, threads, out);
        }
    };
}

impl Real for f32 {
    compile_here!();

    const EPSILON: f64 = Self::EPSILON as f64;
    const LANES: usize = 8;

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
    fn of(x: f64) -> Self {
        x as Self
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(never)]
    fn fourier_plan(length: usize, direction: FftDirection) -> Arc<dyn Fft<Self>> {
        FftPlanner::new().plan_fft(length, direction)
    }

    #[inline(always)]
    fn times_plus<const FUSED: bool>(self, a: Self, b: Self) -> Self {
        if FUSED { Self::mul_add(self, a, b) } else { self * a + b }
    }
}

impl Real for f64 {
    compile_here!();

    const EPSILON: Self = Self::EPSILON;
    const LANES: usize = 4;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(never)]
    fn fourier_plan(length: usize, direction: FftDirection) -> Arc<dyn Fft<Self>> {
        FftPlanner::new().plan_fft(length, direction)
    }

    #[inline(always)]
    fn times_plus<const FUSED: bool>(self, a: Self, b: Self) -> Self {
        if FUSED { Self::mul_add(self, a, b) } else { self * a + b }
    }
}
