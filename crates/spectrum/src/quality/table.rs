use std::f64::consts::PI;

use pulp::Simd;

use super::heat::ShortRange;
use super::kernel::Kernel;

/// The number of values of a row: those of all kernels, filled up to whole registers.
pub(super) const LANES: usize = 16;

/// The number of coefficients of a polynomial. On an eighth of an octave the error is below 1e-16
/// of a kernel's largest value: singularities at v = 0 are 17 half-widths away, and exponentials
/// change by a factor of 3 where they are small.
const COEFFICIENTS: usize = 11;

/// The binary logarithm of the number of polynomials of an octave.
const PARTS: u32 = 3;

/// Bits of a number below those that select the polynomial.
const REST: u32 = 52 - PARTS;

/// Squared distances below belong to coincident points: the rounding of coordinates changes
/// distances by a few EPSILON.
const COINCIDENT: f64 = 4.0 * f64::EPSILON * f64::EPSILON;

/// Piecewise polynomials of the short-range parts of all kernels in `v = r^2/4`, for v from that of
/// coincident points up to the range.
///
/// The polynomial is selected by the exponent and the leading bits of v, so that its argument is
/// exact, and singularities at v = 0 are resolved.
#[derive(Debug)]
pub(super) struct Table {
    rows: Vec<[[f64; LANES]; COEFFICIENTS]>,
    /// The bits that select the first row.
    first: u64,
    range: f64,
}

impl Table {
    /// Returns the table for v up to `range` below 1.
    pub(super) fn new(short: &ShortRange, range: f64) -> Self {
        let first = COINCIDENT.to_bits() >> REST;
        let last = range.to_bits() >> REST;
        let rows = (first..=last).map(|row| {
            let at = |x: f64| {
                let begin = f64::from_bits(row << REST);
                let end = f64::from_bits((row + 1) << REST);
                short.at((begin + (end - begin) * (0.5 * x + 0.5)).min(1.0))
            };
            polynomials(at)
        });
        Self { rows: rows.collect(), first, range }
    }

    /// Returns the largest v with a nonzero value.
    pub(super) fn range(&self) -> f64 {
        self.range
    }

    /// Returns whether points at this v count as coincident.
    #[inline(always)]
    pub(super) fn is_coincident(v: f64) -> bool {
        v <= COINCIDENT
    }

    /// Adds `factor` times the parts of all kernels at v, up to the range, to `sums`. Those that
    /// diverge at 0 are meaningless for coincident points.
    #[inline(always)]
    pub(super) fn add_multiple<S: Simd>(
        &self,
        simd: S,
        v: f64,
        factor: f64,
        sums: &mut [f64; LANES],
    ) {
        let bits = v.max(COINCIDENT).to_bits();
        #[expect(clippy::cast_possible_truncation, reason = "below the number of rows")]
        let row = &self.rows[((bits >> REST) - self.first) as usize];
        // The remaining bits as a number in [1, 1 + 2^-PARTS), mapped to [-1, 1).
        let part = f64::from_bits((bits & ((1 << REST) - 1)) | 1.0_f64.to_bits());
        let x = simd.splat_f64s((part - 1.0) * f64::from(2 << PARTS) - 1.0);
        let factor = simd.splat_f64s(factor);
        for (i, sum) in S::as_mut_simd_f64s(sums).0.iter_mut().enumerate() {
            let mut value = S::as_simd_f64s(&row[COEFFICIENTS - 1]).0[i];
            for coefficients in row[..COEFFICIENTS - 1].iter().rev() {
                value = simd.mul_add_e_f64s(value, x, S::as_simd_f64s(coefficients).0[i]);
            }
            *sum = simd.mul_add_e_f64s(value, factor, *sum);
        }
    }
}

/// Returns the polynomials that interpolate functions at Chebyshev nodes of [-1, 1], by powers.
fn polynomials(at: impl Fn(f64) -> [f64; Kernel::ALL.len()]) -> [[f64; LANES]; COEFFICIENTS] {
    let n = COEFFICIENTS as f64;
    let angles: [f64; COEFFICIENTS] = std::array::from_fn(|i| PI * (i as f64 + 0.5) / n);
    let values = angles.map(|angle| at(angle.cos()));
    let mut out = [[0.0; LANES]; COEFFICIENTS];
    // The powers of the Chebyshev polynomials T_(k-1) and T_k.
    let (mut below, mut current) = ([0.0; COEFFICIENTS], [0.0; COEFFICIENTS]);
    current[0] = 1.0;
    for k in 0..COEFFICIENTS {
        let norm = if k == 0 { 1.0 / n } else { 2.0 / n };
        for kernel in 0..Kernel::ALL.len() {
            let projection = angles.iter().zip(&values);
            let projected: f64 =
                projection.map(|(angle, value)| (k as f64 * angle).cos() * value[kernel]).sum();
            for (row, power) in out.iter_mut().zip(current) {
                row[kernel] += norm * projected * power;
            }
        }
        let factor = if k == 0 { 1.0 } else { 2.0 };
        let next =
            std::array::from_fn(|i| factor * if i == 0 { 0.0 } else { current[i - 1] } - below[i]);
        below = if k == 0 { std::array::from_fn(|i| f64::from(u8::from(i == 0))) } else { current };
        current = next;
    }
    out
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::super::heat::ShortRange;
    use super::{COINCIDENT, Kernel, LANES, Table};

    fn at(table: &Table, v: f64) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        table.add_multiple(Scalar::new(), v, 1.0, &mut sums);
        sums
    }

    /// The scale of errors is the value at 0 where that is finite, otherwise the value at t.
    #[test]
    fn tables_match_the_functions() {
        for (t, range) in [(8e-3, 0.24), (2.5e-5, 8e-4)] {
            let short = ShortRange::new(t);
            let table = Table::new(&short, range);
            let (at_zero, at_t) = (short.at_zero(), short.at(t));
            let mut v = range;
            while v > COINCIDENT {
                let (got, expected) = (at(&table, v), short.at(v));
                for (i, kernel) in Kernel::ALL.into_iter().enumerate() {
                    let scale = if kernel.is_energy() { at_t[i] } else { at_zero[i] };
                    let scale = scale.max(expected[i]);
                    let off = (got[i] - expected[i]).abs() / scale;
                    assert!(off < 4e-15, "{kernel:?}, t = {t}, v = {v}: {off}");
                }
                v *= 0.97;
            }
            let near = at(&table, 0.0);
            for (i, zero) in at_zero.into_iter().enumerate().filter(|(_, zero)| *zero > 0.0) {
                // Kernels of s = 3/2 change by up to twice the chord, which is 4 EPSILON.
                let change = if i < 3 { 8.0 * f64::EPSILON } else { 0.0 };
                let tolerance = change + 1e-14 * zero;
                assert!((near[i] - zero).abs() < tolerance, "kernel {i}: {} {zero}", near[i]);
            }
        }
    }
}
