use pulp::Simd;
use pulp::bytemuck::{Pod, cast_slice};

use sphvar_nufft::parts::Real;

use super::PARTS;
use super::kernel::{Buffers, Columns, Sums};

/// Number type of the values and terms that the Legendre stage multiplies. The recurrence and the
/// sums of partial sums are in f64.
pub(super) trait Number: Pod + Real {
    /// Vectors in registers.
    type Vector<S: Simd>: Pod;

    /// Number of lanes that are summed over before the sums are added in f64, such that their
    /// values for a segment, 16 KiB, stay in the L1 cache.
    const CHUNK: usize;
    /// Multiple of the number of lanes in a vector of any instruction set.
    const PADDING: usize;

    fn vectors<S: Simd>(numbers: &[Self]) -> &[Self::Vector<S>];
    fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [Self::Vector<S>];
    fn splat<S: Simd>(simd: S, x: Self) -> Self::Vector<S>;
    fn add_vectors<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// Returns `a b + c`.
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;
    /// Returns vectors that hold one element of each of the four in turn.
    fn interleave<S: Simd>(simd: S, columns: [Self::Vector<S>; PARTS]) -> [Self::Vector<S>; PARTS];
    /// Writes rounded values.
    fn store<S: Simd, const K: usize>(values: [S::f64s; K], to: &mut [Self]);

    /// Returns the buffers of this type and the sums.
    fn buffers(columns: &mut Columns) -> (&mut Buffers<Self>, &mut Sums);
}

macro_rules! implement {
    (
        $chunk:expr, $padding:expr, $buffers:ident, $vector:ident, $as:ident, $as_mut:ident,
        $splat:ident, $add:ident, $mul_add:ident, $interleave:ident
    ) => {
        type Vector<S: Simd> = S::$vector;

        const CHUNK: usize = $chunk;
        const PADDING: usize = $padding;

        #[inline(always)]
        fn vectors<S: Simd>(numbers: &[Self]) -> &[S::$vector] {
            S::$as(numbers).0
        }

        #[inline(always)]
        fn vectors_mut<S: Simd>(numbers: &mut [Self]) -> &mut [S::$vector] {
            S::$as_mut(numbers).0
        }

        #[inline(always)]
        fn splat<S: Simd>(simd: S, x: Self) -> S::$vector {
            simd.$splat(x)
        }

        #[inline(always)]
        fn add_vectors<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
            simd.$add(a, b)
        }

        #[inline(always)]
        fn mul_add<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
            simd.$mul_add(a, b, c)
        }

        #[inline(always)]
        fn interleave<S: Simd>(simd: S, columns: [S::$vector; PARTS]) -> [S::$vector; PARTS] {
            simd.$interleave(columns)
        }

        #[inline(always)]
        fn buffers(columns: &mut Columns) -> (&mut Buffers<Self>, &mut Sums) {
            columns.$buffers()
        }
    };
}

impl Number for f32 {
    implement!(
        256,
        16,
        single,
        f32s,
        as_simd_f32s,
        as_mut_simd_f32s,
        splat_f32s,
        add_f32s,
        mul_add_e_f32s,
        interleave_shfl_f32s
    );

    #[inline(always)]
    fn store<S: Simd, const K: usize>(values: [S::f64s; K], to: &mut [Self]) {
        let values: &[f64] = cast_slice(&values);
        for (to, value) in to.iter_mut().zip(values) {
            *to = Self::of(*value);
        }
    }
}

impl Number for f64 {
    implement!(
        128,
        8,
        double,
        f64s,
        as_simd_f64s,
        as_mut_simd_f64s,
        splat_f64s,
        add_f64s,
        mul_add_e_f64s,
        interleave_shfl_f64s
    );

    #[inline(always)]
    fn store<S: Simd, const K: usize>(values: [S::f64s; K], to: &mut [Self]) {
        let (to, _) = S::as_mut_simd_f64s(to);
        to[..K].copy_from_slice(&values);
    }
}

/// Returns the first `K` vectors of some numbers.
#[inline(always)]
pub(super) fn load<S: Simd, T: Number, const K: usize>(from: &[T]) -> [T::Vector<S>; K] {
    let vectors = T::vectors::<S>(&from[..K * (size_of::<T::Vector<S>>() / size_of::<T>())]);
    std::array::from_fn(|k| vectors[k])
}
