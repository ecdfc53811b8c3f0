//! The recurrence at many colatitudes at once, one colatitude per register lane.

use core::ops::Range;

use pulp::{Simd, WithSimd};

use crate::{
    Colatitude, Recurrence, Scaled, Step,
    recurrence::{BLOCK_FACTOR, State},
    sectoral::sectoral,
};

/// Number of colatitudes that pass through all degrees together: a multiple of `TOGETHER` vectors
/// of every width, so that the blocks of a list do not depend on the processor.
pub(crate) const LANES: usize = 48;

/// Number of vectors whose recurrences alternate. A step of one vector has a latency of 4
/// operations, during which the processor completes about this number of steps of other vectors;
/// three numbers per vector still fit in 16 registers except for the versines.
const TOGETHER: usize = 6;

/// Number of degrees between two checks of the scales, even.
///
/// A step to degree `m + n` multiplies a value by at most `sqrt((2m + n)/n)`, so this number of steps
/// by less than `2^145` up to [`MAX_DEGREE`](crate::MAX_DEGREE). A value that is at most 1 in its
/// scale therefore does not skip the next one, of `2^512`, and is below the range of f64 on the way
/// if its scale is 3 or more.
const SPAN: usize = 16;

/// Values of consecutive degrees at the colatitudes of a block.
type Tile = [[f64; LANES]; SPAN];

/// Calls `visit` for a range of degrees at all colatitudes, one block of colatitudes after the
/// other; see [`Recurrence::for_each_block`].
pub(crate) struct Blocks<'a, F> {
    pub(crate) recurrence: &'a Recurrence,
    /// The degrees `l - m` to visit, at least one, within those of the recurrence.
    pub(crate) visited: Range<usize>,
    pub(crate) colatitudes: &'a [Colatitude],
    pub(crate) visit: F,
}

impl<F: FnMut(usize, Range<usize>, &[f64])> WithSimd for Blocks<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { recurrence, visited, colatitudes, mut visit } = self;
        let (m, steps) = (recurrence.order(), recurrence.steps());
        let constant = Scaled::new(sectoral(m), 0);
        let mut tile: Tile = [[0.0; LANES]; SPAN];
        // Tiles start at even degrees l - m, so that the rows of odd ones are the same in each.
        let first_tile = visited.start / 2 * 2;
        for (block, colatitudes) in colatitudes.chunks(LANES).enumerate() {
            let range = block * LANES..block * LANES + colatitudes.len();
            let mut lanes = Lanes::start(m, constant, colatitudes);
            lanes.skip(simd, &steps[..first_tile]);
            for start in (first_tile..visited.end).step_by(SPAN) {
                let end = visited.end.min(start + SPAN);
                lanes.fill(simd, &steps[start..end], &mut tile);
                let first = start.max(visited.start);
                for (n, row) in (first..end).zip(&tile[first - start..]) {
                    visit(m + n, range.clone(), &row[..range.len()]);
                }
            }
        }
    }
}

/// The [`State`] of each colatitude of a block, in the acute angle.
struct Lanes {
    /// The number of colatitudes; the others are at the pole.
    len: usize,
    versine: [f64; LANES],
    /// -0.0 in the south, where values of odd `l - m` change sign, and 0.0 in the north.
    sign: [f64; LANES],
    value: [f64; LANES],
    difference: [f64; LANES],
    /// `lambda_lm = value * BLOCK_FACTOR^scale`; a scale is 0 once a value is in the range of f64.
    scale: [f64; LANES],
    /// See [`Self::set_factors`].
    factor: [f64; LANES],
    /// Whether any scale is not 0.
    has_scaled: bool,
}

impl Lanes {
    /// Returns the states at degree `m`, where `constant` is `sectoral(m)`.
    #[inline(always)]
    fn start(m: usize, constant: Scaled, colatitudes: &[Colatitude]) -> Self {
        let mut lanes = Self {
            len: colatitudes.len(),
            versine: [0.0; LANES],
            sign: [0.0; LANES],
            value: [0.0; LANES],
            difference: [0.0; LANES],
            scale: [0.0; LANES],
            factor: [1.0; LANES],
            has_scaled: false,
        };
        let mut sines = Numbers::ZERO;
        for (i, colatitude) in colatitudes.iter().enumerate() {
            lanes.versine[i] = colatitude.versine();
            lanes.sign[i] = if colatitude.is_south() { -0.0 } else { 0.0 };
            sines.set(i, Scaled::new(colatitude.sin(), 0));
        }
        let starts = sines.power(m).times(&Numbers::splat(constant));
        for i in 0..colatitudes.len() {
            let state = State::start(starts.get(i));
            lanes.value[i] = state.value;
            lanes.scale[i] = state.blocks as f64;
            lanes.has_scaled |= state.blocks > 0;
        }
        lanes.set_factors();
        lanes
    }

    /// Advances by steps without storing the values.
    #[inline(always)]
    fn skip<S: Simd>(&mut self, simd: S, steps: &[Step]) {
        let mut rest = steps;
        while self.has_scaled && !rest.is_empty() {
            let (span, after) = rest.split_at(SPAN.min(rest.len()));
            self.run::<S, SKIP>(simd, span, &mut []);
            self.raise_scales(simd);
            rest = after;
        }
        self.run::<S, SKIP>(simd, rest, &mut []);
    }

    /// Writes the values before each of at most `SPAN` steps to the rows of the tile, and advances.
    /// The first row must be of an even degree `l - m`.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, steps: &[Step], tile: &mut Tile) {
        if self.has_scaled {
            self.run::<S, UNSCALE>(simd, steps, tile);
            self.unscale_rest(&mut tile[..steps.len()]);
            self.raise_scales(simd);
        } else {
            self.run::<S, STORE>(simd, steps, tile);
        }
    }

    /// Advances by steps; `MODE` selects whether values are stored, and whether they are multiplied
    /// by [`Self::factor`].
    #[inline(always)]
    fn run<S: Simd, const MODE: u8>(&mut self, simd: S, steps: &[Step], tile: &mut [[f64; LANES]]) {
        let groups = self.len.div_ceil(TOGETHER * S::F64_LANES);
        let versine = groups_of::<S>(&self.versine);
        let sign = groups_of::<S>(&self.sign);
        let factor = groups_of::<S>(&self.factor);
        let value = groups_of_mut::<S>(&mut self.value);
        let difference = groups_of_mut::<S>(&mut self.difference);
        for group in 0..groups {
            let (versine, sign, factor) = (&versine[group], &sign[group], &factor[group]);
            let (mut l, mut d) = (value[group], difference[group]);
            if MODE == SKIP {
                for &step in steps {
                    advance(simd, step, versine, &mut l, &mut d);
                }
            } else {
                for (steps, rows) in steps.chunks(2).zip(tile.chunks_mut(2)) {
                    let row = &mut groups_of_mut::<S>(&mut rows[0])[group];
                    for k in 0..TOGETHER {
                        row[k] =
                            if MODE == UNSCALE { simd.mul_f64s(l[k], factor[k]) } else { l[k] };
                    }
                    advance(simd, steps[0], versine, &mut l, &mut d);
                    if let ([_, step], [_, row]) = (steps, rows) {
                        let row = &mut groups_of_mut::<S>(row)[group];
                        for k in 0..TOGETHER {
                            let l =
                                if MODE == UNSCALE { simd.mul_f64s(l[k], factor[k]) } else { l[k] };
                            row[k] = simd.xor_f64s(l, sign[k]);
                        }
                        advance(simd, *step, versine, &mut l, &mut d);
                    }
                }
            }
            value[group] = l;
            difference[group] = d;
        }
    }

    /// Moves lanes whose values have grown enough to the next scale; see [`State::advance`].
    #[inline(always)]
    fn raise_scales<S: Simd>(&mut self, simd: S) {
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let down = simd.splat_f64s(BLOCK_FACTOR);
        let mut largest = zero;
        let vectors = S::as_mut_simd_f64s(&mut self.value)
            .0
            .iter_mut()
            .zip(S::as_mut_simd_f64s(&mut self.difference).0)
            .zip(S::as_mut_simd_f64s(&mut self.scale).0);
        for ((value, difference), scale) in vectors {
            let grown = simd.greater_than_f64s(simd.abs_f64s(*value), one);
            let raise = simd.and_m64s(grown, simd.greater_than_f64s(*scale, zero));
            let factor = simd.select_f64s(raise, down, one);
            *value = simd.mul_f64s(*value, factor);
            *difference = simd.mul_f64s(*difference, factor);
            *scale = simd.sub_f64s(*scale, simd.select_f64s(raise, one, zero));
            largest = simd.max_f64s(largest, *scale);
        }
        self.has_scaled = simd.reduce_max_f64s(largest) > 0.0;
        self.set_factors();
    }

    /// Sets the factors that convert values to the scale 0, except for [`Self::unscale_rest`].
    #[inline(always)]
    fn set_factors(&mut self) {
        for (factor, &scale) in self.factor.iter_mut().zip(&self.scale) {
            let scaled = if scale > 2.0 { 0.0 } else { BLOCK_FACTOR };
            *factor = if scale > 0.0 { scaled } else { 1.0 };
        }
    }

    /// Multiplies the stored values of scale 2 by the second factor. Only this product rounds. At
    /// most a few lanes of a block are at this scale, which a value passes through once.
    #[inline(always)]
    fn unscale_rest(&self, rows: &mut [[f64; LANES]]) {
        for lane in (0..self.len).filter(|&lane| self.scale[lane] > 1.0 && self.scale[lane] < 3.0) {
            for row in &mut *rows {
                row[lane] *= BLOCK_FACTOR;
            }
        }
    }
}

/// Modes of [`Lanes::run`].
const SKIP: u8 = 0;
const STORE: u8 = 1;
const UNSCALE: u8 = 2;

/// The operations of [`State::advance`], in the same order, without a change of scale.
#[inline(always)]
fn advance<S: Simd>(
    simd: S,
    step: Step,
    versine: &[S::f64s; TOGETHER],
    value: &mut [S::f64s; TOGETHER],
    difference: &mut [S::f64s; TOGETHER],
) {
    let growth = simd.splat_f64s(step.growth);
    let damping = simd.splat_f64s(step.damping);
    let forcing = simd.splat_f64s(step.forcing);
    for k in 0..TOGETHER {
        let forced = simd.mul_f64s(forcing, simd.mul_f64s(versine[k], value[k]));
        difference[k] = simd.sub_f64s(simd.mul_f64s(damping, difference[k]), forced);
        value[k] = simd.add_f64s(simd.mul_f64s(growth, value[k]), difference[k]);
    }
}

#[inline(always)]
fn groups_of<S: Simd>(numbers: &[f64; LANES]) -> &[[S::f64s; TOGETHER]] {
    S::as_simd_f64s(numbers).0.as_chunks().0
}

#[inline(always)]
fn groups_of_mut<S: Simd>(numbers: &mut [f64; LANES]) -> &mut [[S::f64s; TOGETHER]] {
    S::as_mut_simd_f64s(numbers).0.as_chunks_mut().0
}

/// A [`Scaled`] number per lane.
#[derive(Clone, Copy)]
struct Numbers {
    mantissa: [f64; LANES],
    exponent: [i64; LANES],
}

impl Numbers {
    const ZERO: Self = Self::splat(Scaled::ZERO);

    const fn splat(number: Scaled) -> Self {
        Self { mantissa: [number.mantissa; LANES], exponent: [number.exponent; LANES] }
    }

    fn get(&self, lane: usize) -> Scaled {
        Scaled { mantissa: self.mantissa[lane], exponent: self.exponent[lane] }
    }

    fn set(&mut self, lane: usize, number: Scaled) {
        self.mantissa[lane] = number.mantissa;
        self.exponent[lane] = number.exponent;
    }

    /// Returns the powers, as [`Scaled::power`] does for each.
    #[inline(always)]
    fn power(self, n: usize) -> Self {
        let (mut result, mut square, mut rest) = (Self::splat(Scaled::ONE), self, n);
        while rest > 0 {
            if rest % 2 == 1 {
                result = result.times(&square);
            }
            rest /= 2;
            if rest > 0 {
                square = square.times(&square);
            }
        }
        result
    }

    /// Returns the products of numbers in normal form, in normal form.
    #[inline(always)]
    fn times(self, other: &Self) -> Self {
        /// Beyond every exponent that matters, and far from the largest integer.
        const LIMIT: i64 = i64::MAX / 4;
        let mut product = self;
        for i in 0..LANES {
            let mantissa = self.mantissa[i] * other.mantissa[i];
            // The product of two mantissas in [1, 2) is below 4.
            let carries = mantissa.abs() >= 2.0;
            product.mantissa[i] = if carries { 0.5 * mantissa } else { mantissa };
            let exponent = self.exponent[i] + other.exponent[i] + i64::from(carries);
            product.exponent[i] = exponent.clamp(-LIMIT, LIMIT);
        }
        product
    }
}
