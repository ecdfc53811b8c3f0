use sphvar_nufft::parts::add_with_rests;

use super::walk::State;
use crate::legendre::number::Number;

/// Bytes.
const CACHE_LINE: usize = 64;

/// Workspace: the factors and the product.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    single: Buffers<f32>,
    double: Buffers<f64>,
    pub(super) sums: Sums,
}

/// The part of the workspace that depends on the number type.
#[derive(Clone, Debug, Default)]
pub(in crate::legendre) struct Buffers<T> {
    /// The terms that the adjoint sums over lanes; see [`Group::gather`].
    pub(super) by_lane: Aligned<T>,
    /// The terms that synthesis sums over degrees: `PARTS` numbers for each degree and function.
    pub(super) by_degree: Vec<T>,
    /// Values of the recurrence, indexed by degree within a segment and by lane within a chunk.
    pub(super) tile: Aligned<T>,
    /// Sums over the degrees of some segments.
    pub(super) partial: Aligned<T>,
}

/// Sums in f64.
#[derive(Clone, Debug, Default)]
pub(in crate::legendre) struct Sums {
    /// Sums over lanes, indexed by form: `PARTS` numbers for each degree and function.
    pub(super) by_degree: [Vec<f64>; 4],
    /// Those of all forms together.
    pub(super) total: Vec<f64>,
    /// Sums over degrees, arranged like `by_lane`.
    pub(super) by_lane: Vec<f64>,
    pub(super) long: LongSums,
    pub(super) state: State,
}

/// Sums over rings that are too long for a single partial sum.
#[derive(Clone, Debug, Default)]
pub(super) struct LongSums {
    sums: Vec<f64>,
    rests: Vec<f64>,
}

impl LongSums {
    pub(super) fn clear(&mut self, len: usize) {
        for column in [&mut self.sums, &mut self.rests] {
            column.clear();
            column.resize(len, 0.0);
        }
    }

    /// Adds partial sums and sets them to zero. In one long sum all rounding errors can have the
    /// same sign.
    #[inline(always)]
    pub(super) fn flush(&mut self, short: &mut [f64]) {
        add_with_rests(&mut self.sums, &mut self.rests, short);
        short.fill(0.0);
    }

    pub(super) fn write(&self, out: &mut [f64]) {
        for (out, (sum, rest)) in out.iter_mut().zip(self.sums.iter().zip(&self.rests)) {
            *out = sum + rest;
        }
    }
}

/// Numbers at the start of a cache line, so that no vector crosses the end of one.
#[derive(Clone, Debug, Default)]
pub(super) struct Aligned<T>(Vec<T>);

impl<T: Number> Aligned<T> {
    /// Returns `len` numbers of unspecified values.
    #[inline(always)]
    pub(super) fn numbers(&mut self, len: usize) -> &mut [T] {
        let slack = CACHE_LINE / size_of::<T>();
        self.0.resize(self.0.len().max(len + slack), T::of(0.0));
        let start = self.0.as_ptr().align_offset(CACHE_LINE).min(slack);
        &mut self.0[start..start + len]
    }
}

impl Columns {
    pub(in crate::legendre) fn single(&mut self) -> (&mut Buffers<f32>, &mut Sums) {
        (&mut self.single, &mut self.sums)
    }

    pub(in crate::legendre) fn double(&mut self) -> (&mut Buffers<f64>, &mut Sums) {
        (&mut self.double, &mut self.sums)
    }
}
