//! One order m of the Legendre transform: the recurrence over l for vectors of rings.

use num_complex::Complex;
use pulp::{Simd, WithSimd};
use sphvar_sh::{Recurrence, Step};

use crate::lanes::{BLOCK, Lanes, PARTS, SCALE_BITS};

const SCALE_DOWN: f64 = f64::from_bits((1023 - SCALE_BITS as u64) << 52);
/// A value beyond this moves to the next scale. One step multiplies by at most 2 sqrt(2m+3), so
/// `STEPS_PER_CHECK` of them stay within the range of f64 for any m below 10^9.
const SCALE_LIMIT: f64 = f64::from_bits((1023 + SCALE_BITS as u64 / 2) << 52);
const STEPS_PER_CHECK: usize = 8;

/// Functions that share one pass of the recurrence.
const FUNCTIONS: usize = 4;

/// The sums over the rings of `lambda_lm f_m` for one m, every l from m, and several functions f.
pub(crate) struct Column<'a> {
    pub(crate) lanes: &'a Lanes,
    pub(crate) n_functions: usize,
    pub(crate) recurrence: &'a Recurrence,
    /// Scratch: a vector register's worth of partial sums per l and function, real and imaginary.
    pub(crate) sums: &'a mut Vec<f64>,
    /// By function and degree.
    pub(crate) out: &'a mut Vec<Complex<f64>>,
}

impl WithSimd for Column<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, n_functions, recurrence, sums, out } = self;
        let steps = recurrence.steps();
        out.clear();
        let mut first = 0;
        while first < n_functions {
            let several = if n_functions - first >= FUNCTIONS { FUNCTIONS } else { 1 };
            sums.clear();
            sums.resize(several * 2 * S::F64_LANES * steps.len(), 0.0);
            let (partial, _) = S::as_mut_simd_f64s(sums);
            let terms = Terms { all: &lanes.terms, n_functions, first };
            // Enough independent chains to hide the latency of the recurrence, few enough to stay in
            // registers: of the wide kind there are 32, of the others 16.
            match (several, S::F64_LANES >= 8) {
                (1, true) => accumulate::<S, 4, 1>(simd, lanes, terms, steps, partial),
                (1, false) => accumulate::<S, 2, 1>(simd, lanes, terms, steps, partial),
                (_, true) => accumulate::<S, 4, FUNCTIONS>(simd, lanes, terms, steps, partial),
                (_, false) => accumulate::<S, 2, FUNCTIONS>(simd, lanes, terms, steps, partial),
            }
            for function in 0..several {
                let of_degree = partial.chunks_exact(2 * several);
                out.extend(of_degree.map(|sum| {
                    let (re, im) = (sum[2 * function], sum[2 * function + 1]);
                    Complex::new(simd.reduce_sum_f64s(re), simd.reduce_sum_f64s(im))
                }));
            }
            first += several;
        }
    }
}

/// The terms of some of the functions.
#[derive(Clone, Copy)]
struct Terms<'a> {
    all: &'a [f64],
    n_functions: usize,
    first: usize,
}

/// `K` vectors of rings at one degree of the recurrence, with the terms of `F` functions.
struct Group<S: Simd, const K: usize, const F: usize> {
    versine: [S::f64s; K],
    /// `lambda_lm` and its difference (see [`Recurrence`]), in the scale of the ring.
    lambda: [S::f64s; K],
    difference: [S::f64s; K],
    terms: [[[S::f64s; K]; PARTS]; F],
}

/// Adds the terms of all rings to `sums`: by degree and function, a vector for each part.
#[inline(always)]
fn accumulate<S: Simd, const K: usize, const F: usize>(
    simd: S,
    lanes: &Lanes,
    terms: Terms<'_>,
    steps: &[Step],
    sums: &mut [S::f64s],
) {
    let (versine, _) = S::as_simd_f64s(&lanes.versine);
    let (start, _) = S::as_simd_f64s(&lanes.start);
    let (scale, _) = S::as_simd_f64s(&lanes.scale);
    let (all_terms, _) = S::as_simd_f64s(terms.all);
    let per_block = BLOCK / S::F64_LANES;
    for first in (0..versine.len()).step_by(K) {
        let at =
            |column: &[S::f64s]| -> [S::f64s; K] { std::array::from_fn(|i| column[first + i]) };
        let (block, offset) = (first / per_block, first % per_block);
        let part = |function: usize, part: usize| {
            let place = (block * terms.n_functions + terms.first + function) * PARTS + part;
            let vectors = &all_terms[place * per_block + offset..][..K];
            std::array::from_fn(|i| vectors[i])
        };
        let mut group = Group::<S, K, F> {
            versine: at(versine),
            lambda: at(start),
            difference: [simd.splat_f64s(0.0); K],
            terms: std::array::from_fn(|f| std::array::from_fn(|p| part(f, p))),
        };
        group.run(simd, at(scale), steps, sums);
    }
}

impl<S: Simd, const K: usize, const F: usize> Group<S, K, F> {
    /// All degrees of the order.
    #[inline(always)]
    fn run(&mut self, simd: S, scale: [S::f64s; K], steps: &[Step], sums: &mut [S::f64s]) {
        let begun = self.climb(simd, scale, steps, sums);
        // `climb` stops at an even number of degrees, or at the end.
        let mut pairs = sums[2 * F * begun..].chunks_exact_mut(4 * F);
        let mut step_pairs = steps[begun..].chunks_exact(2);
        for (sum, step) in (&mut pairs).zip(&mut step_pairs) {
            let (even, odd) = sum.split_at_mut(2 * F);
            self.add::<0>(simd, self.lambda, even);
            self.step(simd, &step[0]);
            self.add::<1>(simd, self.lambda, odd);
            self.step(simd, &step[1]);
        }
        if !step_pairs.remainder().is_empty() {
            self.add::<0>(simd, self.lambda, pairs.into_remainder());
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
            let all_below = scale.iter().all(|&s| simd.reduce_max_f64s(s) < 0.0);
            let until = (done + STEPS_PER_CHECK).min(steps.len());
            for l in done..until {
                if !all_below {
                    let visible = std::array::from_fn(|i| {
                        simd.select_f64s(simd.less_than_f64s(scale[i], zero), zero, self.lambda[i])
                    });
                    let sum = &mut sums[2 * F * l..2 * F * (l + 1)];
                    if l % 2 == 0 {
                        self.add::<0>(simd, visible, sum);
                    } else {
                        self.add::<1>(simd, visible, sum);
                    }
                }
                self.step(simd, &steps[l]);
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

    /// Adds the terms of one degree, l + m of parity `ODD`, with `lambda` for its values.
    #[inline(always)]
    fn add<const ODD: usize>(&self, simd: S, lambda: [S::f64s; K], sum: &mut [S::f64s]) {
        for function in 0..F {
            let re = &self.terms[function][2 * ODD];
            let im = &self.terms[function][2 * ODD + 1];
            let (mut sum_re, mut sum_im) = (sum[2 * function], sum[2 * function + 1]);
            for i in 0..K {
                sum_re = simd.mul_add_f64s(lambda[i], re[i], sum_re);
                sum_im = simd.mul_add_f64s(lambda[i], im[i], sum_im);
            }
            (sum[2 * function], sum[2 * function + 1]) = (sum_re, sum_im);
        }
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
