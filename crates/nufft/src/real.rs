use std::ops::AddAssign;
use std::sync::Arc;

use rustfft::{Fft, FftDirection, FftNum, FftPlanner};

/// Number type of a grid: f32 if the requested accuracy permits, otherwise f64.
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
}

impl Real for f32 {
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
