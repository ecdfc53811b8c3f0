//! One order m of the Legendre transform: the recurrence over l for vectors of rings.

use num_complex::Complex;
use pulp::{Simd, WithSimd};
use sphvar_sh::{Recurrence, Step};

use crate::lanes::{Lanes, SCALE_BITS};

const SCALE_DOWN: f64 = f64::from_bits((1023 - SCALE_BITS as u64) << 52);
/// A value beyond this moves to the next scale. One step multiplies by at most 2 sqrt(2m+3), so
/// `STEPS_PER_CHECK` of them stay within the range of f64 for any m below 10^9.
const SCALE_LIMIT: f64 = f64::from_bits((1023 + SCALE_BITS as u64 / 2) << 52);
const STEPS_PER_CHECK: usize = 8;

/// The sums over the rings of `lambda_lm f_m` for one m and every l from m.
pub(crate) struct Column<'a> {
    pub(crate) lanes: &'a Lanes,
    pub(crate) recurrence: &'a Recurrence,
    /// Scratch: a vector register's worth of partial sums per l, real and imaginary.
    pub(crate) sums: &'a mut Vec<f64>,
    pub(crate) out: &'a mut Vec<Complex<f64>>,
}

impl WithSimd for Column<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, recurrence, sums, out } = self;
        let steps = recurrence.steps();
        out.clear();
        if lanes.is_empty() {
            out.resize(steps.len(), Complex::ZERO);
            return;
        }
        sums.clear();
        sums.resize(2 * S::F64_LANES * (steps.len()), 0.0);
        let (sums, _) = S::as_mut_simd_f64s(sums);
        // Enough independent chains to hide the latency of the recurrence, few enough to stay in
        // registers: of the wide kind there are 32, of the others 16.
        if S::F64_LANES >= 8 {
            accumulate::<S, 4>(simd, lanes, steps, sums);
        } else {
            accumulate::<S, 2>(simd, lanes, steps, sums);
        }
        let total =
            |s: &[S::f64s]| Complex::new(simd.reduce_sum_f64s(s[0]), simd.reduce_sum_f64s(s[1]));
        out.extend(sums.chunks_exact(2).map(total));
    }
}

/// `K` vectors of rings at one degree of the recurrence.
struct Group<S: Simd, const K: usize> {
    versine: [S::f64s; K],
    re: [S::f64s; K],
    im: [S::f64s; K],
    /// `lambda_lm` and its difference (see [`Recurrence`]), in the scale of the ring.
    lambda: [S::f64s; K],
    difference: [S::f64s; K],
}

/// Adds the terms of all rings to `sums`, two vectors for each degree.
#[inline(always)]
fn accumulate<S: Simd, const K: usize>(
    simd: S,
    lanes: &Lanes,
    steps: &[Step],
    sums: &mut [S::f64s],
) {
    let (versine, _) = S::as_simd_f64s(&lanes.versine);
    let (re, _) = S::as_simd_f64s(&lanes.re);
    let (im, _) = S::as_simd_f64s(&lanes.im);
    let (start, _) = S::as_simd_f64s(&lanes.start);
    let (scale, _) = S::as_simd_f64s(&lanes.scale);
    for first in (0..versine.len()).step_by(K) {
        let at =
            |column: &[S::f64s]| -> [S::f64s; K] { std::array::from_fn(|i| column[first + i]) };
        let mut group = Group::<S, K> {
            versine: at(versine),
            re: at(re),
            im: at(im),
            lambda: at(start),
            difference: [simd.splat_f64s(0.0); K],
        };
        group.run(simd, at(scale), steps, sums);
    }
}

impl<S: Simd, const K: usize> Group<S, K> {
    /// All degrees of the order.
    #[inline(always)]
    fn run(&mut self, simd: S, scale: [S::f64s; K], steps: &[Step], sums: &mut [S::f64s]) {
        let begun = self.climb(simd, scale, steps, sums);
        let rest = sums[2 * begun..].chunks_exact_mut(2);
        for (step, sum) in steps[begun..].iter().zip(rest) {
            self.add(simd, self.lambda, sum);
            self.step(simd, step);
        }
    }

    /// Runs the recurrence while some value is below the range of f64, counting such values as
    /// the zeros that they are in the sum, and returns the number of degrees done.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "several arrays run in step")]
    fn climb(
        &mut self,
        simd: S,
        mut scale: [S::f64s; K],
        steps: &[Step],
        sums: &mut [S::f64s],
    ) -> usize {
        let zero = simd.splat_f64s(0.0);
        let one = simd.splat_f64s(1.0);
        let limit = simd.splat_f64s(SCALE_LIMIT);
        let down = simd.splat_f64s(SCALE_DOWN);
        let mut done = 0;
        while done < steps.len() && scale.iter().any(|&s| simd.reduce_min_f64s(s) < 0.0) {
            let visible = |lambda: &[S::f64s; K]| {
                std::array::from_fn(|i| {
                    simd.select_f64s(simd.less_than_f64s(scale[i], zero), zero, lambda[i])
                })
            };
            let until = (done + STEPS_PER_CHECK).min(steps.len());
            for (step, sum) in steps[done..until].iter().zip(sums[2 * done..].chunks_exact_mut(2)) {
                self.add(simd, visible(&self.lambda), sum);
                self.step(simd, step);
            }
            for i in 0..K {
                let size =
                    simd.max_f64s(simd.abs_f64s(self.lambda[i]), simd.abs_f64s(self.difference[i]));
                let over = simd.less_than_f64s(limit, size);
                let factor = simd.select_f64s(over, down, one);
                self.lambda[i] = simd.mul_f64s(self.lambda[i], factor);
                self.difference[i] = simd.mul_f64s(self.difference[i], factor);
                scale[i] = simd.add_f64s(scale[i], simd.select_f64s(over, one, zero));
            }
            done = until;
        }
        done
    }

    /// Adds the terms of one degree, with `lambda` for its values.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "several arrays run in step")]
    fn add(&self, simd: S, lambda: [S::f64s; K], sum: &mut [S::f64s]) {
        let (mut re, mut im) = (sum[0], sum[1]);
        for i in 0..K {
            re = simd.mul_add_f64s(lambda[i], self.re[i], re);
            im = simd.mul_add_f64s(lambda[i], self.im[i], im);
        }
        (sum[0], sum[1]) = (re, im);
    }

    /// From one degree to the next.
    #[inline(always)]
    fn step(&mut self, simd: S, step: &Step) {
        let growth = simd.splat_f64s(step.growth);
        let damping = simd.splat_f64s(step.damping);
        let forcing = simd.splat_f64s(step.forcing);
        for k in 0..K {
            let damped = simd.mul_f64s(damping, self.difference[k]);
            let forced = simd.mul_f64s(forcing, self.versine[k]);
            self.difference[k] = simd.negate_mul_add_f64s(forced, self.lambda[k], damped);
            self.lambda[k] = simd.mul_add_f64s(growth, self.lambda[k], self.difference[k]);
        }
    }
}
