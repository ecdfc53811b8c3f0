//! Sums of products of long rows, from which Gram matrices and Cholesky factors are computed.

use pulp::{Simd, WithSimd};

/// Rows and columns of the blocks of results that registers hold.
const BLOCK: usize = 4;

/// Entries of a row in one pass, such that the rows of two tiles stay in the second-level cache.
const DEPTH: usize = 512;

/// Lengths of rows are multiples of this number, so vectors of every width cover them.
pub(super) const LANES: usize = 8;

/// Adds `sign sum_k a_ik b_jk` to `out_ij` for the rows of two matrices.
///
/// Entries of `out` with the same index are bit-identical for any tiling, because each is a sum
/// over k in one order.
pub(super) struct AddProducts<'a> {
    /// The rows of the first matrix, `stride` apart.
    pub(super) left: &'a [f64],
    /// The rows of the second matrix, `stride` apart.
    pub(super) right: &'a [f64],
    pub(super) stride: usize,
    /// The number of entries of a row in use, a multiple of [`LANES`].
    pub(super) len: usize,
    /// The results, those of a row of `left` `out_stride` apart.
    pub(super) out: &'a mut [f64],
    pub(super) out_stride: usize,
    /// The numbers of rows of `left` and `right`.
    pub(super) shape: [usize; 2],
    pub(super) sign: f64,
}

impl WithSimd for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { left, right, stride, len, out, out_stride, shape: [m, n], sign } = self;
        for from in (0..len).step_by(DEPTH) {
            let depth = DEPTH.min(len - from);
            let row = |rows, i: usize| S::as_simd_f64s(slice(rows, i, stride, from, depth)).0;
            for i in (0..m).step_by(BLOCK) {
                // Rows beyond the last repeat it; their results are discarded.
                let a: [_; BLOCK] = std::array::from_fn(|k| row(left, (i + k).min(m - 1)));
                for j in (0..n).step_by(BLOCK) {
                    let b: [_; BLOCK] = std::array::from_fn(|k| row(right, (j + k).min(n - 1)));
                    let sums = block(simd, a, b);
                    for (k, sums) in sums.iter().enumerate().take(m - i) {
                        let out = &mut out[(i + k) * out_stride + j..];
                        for (out, sum) in out.iter_mut().zip(sums).take(n - j) {
                            *out += sign * sum;
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn slice(rows: &[f64], i: usize, stride: usize, from: usize, depth: usize) -> &[f64] {
    &rows[i * stride + from..][..depth]
}

/// Returns the products of four rows with four others.
#[inline(always)]
fn block<S: Simd>(
    simd: S,
    a: [&[S::f64s]; BLOCK],
    b: [&[S::f64s]; BLOCK],
) -> [[f64; BLOCK]; BLOCK] {
    let len = a[0].len();
    let (a, b) = (a.map(|row| &row[..len]), b.map(|row| &row[..len]));
    let mut sums = [[simd.splat_f64s(0.0); BLOCK]; BLOCK];
    for k in 0..len {
        for i in 0..BLOCK {
            for j in 0..BLOCK {
                sums[i][j] = simd.mul_add_f64s(a[i][k], b[j][k], sums[i][j]);
            }
        }
    }
    sums.map(|row| row.map(|sum| simd.reduce_sum_f64s(sum)))
}
