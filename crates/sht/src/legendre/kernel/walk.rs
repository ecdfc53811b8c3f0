use std::ops::Range;

use pulp::Simd;

use super::product::Product;
use crate::legendre::RINGS;
use crate::legendre::lanes::Scale;
use crate::legendre::number::{Number, load};
use crate::legendre::order::{Sequence, Step};

/// Number of vectors that pass through the recurrence together, to hide its latency.
const TOGETHER: usize = 4;

/// The largest number of lanes of a chunk.
const MAX_CHUNK: usize = 256;

/// The recurrence at the lanes of a chunk, segment by segment.
pub(super) struct Walk<'a> {
    pub(super) sequence: &'a Sequence,
    smallest: f64,
    argument: &'a [f64],
    value: &'a mut [f64],
    /// The difference, or the value before.
    other: &'a mut [f64],
    scale: &'a mut [f64],
    settled: &'a mut [bool],
}

impl<'a> Walk<'a> {
    #[inline(always)]
    pub(super) fn start<T: Number>(
        product: Product<'a>,
        lanes: Range<usize>,
        state: &'a mut State,
    ) -> Self {
        let Product { group, order, form, arithmetic } = product;
        let count = lanes.len();
        let padded = count.next_multiple_of(T::PADDING);
        let State { value, other, scale, settled } = state;
        let (value, other) = (&mut value.0[..padded], &mut other.0[..padded]);
        let scale = &mut scale.0[..padded];
        value[..count].copy_from_slice(&group.start[lanes.clone()]);
        scale[..count].copy_from_slice(&group.scale[lanes.clone()]);
        // Padding lanes must not affect decisions.
        value[count..].fill(0.0);
        scale[count..].fill(0.0);
        other.fill(0.0);
        settled.fill(false);
        Self {
            sequence: order.sequence(form),
            smallest: arithmetic.smallest(),
            argument: &group.argument[lanes.start..lanes.start + padded],
            value,
            other,
            scale,
            settled,
        }
    }

    /// Runs the steps of a segment and stores the values before each, unless they are negligible.
    /// Returns the number of leading lanes that include all significant ones, a multiple of
    /// `PADDING`.
    #[inline(always)]
    pub(super) fn advance<S: Simd, T: Number, const DIFFERENCES: bool>(
        &mut self,
        simd: S,
        segment: usize,
        steps: &[Step],
        tile: &mut [T],
    ) -> usize {
        let padded = self.value.len();
        let mut used = 0;
        let mut is_skipped = [false; MAX_CHUNK / RINGS];
        for (i, first) in (0..padded).step_by(RINGS).enumerate() {
            let range = first..padded.min(first + RINGS);
            let mut lanes = Block {
                argument: &self.argument[range.clone()],
                value: &mut self.value[range.clone()],
                other: &mut self.other[range.clone()],
                scale: &mut self.scale[range.clone()],
            };
            if !self.settled[i] && lanes.are_all_scaled() {
                lanes.run::<S, T, DIFFERENCES, false>(simd, steps, first, tile);
                lanes.rescale::<DIFFERENCES>(self.sequence, segment);
                lanes.raise();
                is_skipped[i] = true;
                continue;
            }
            lanes.run::<S, T, DIFFERENCES, true>(simd, steps, first, tile);
            lanes.rescale::<DIFFERENCES>(self.sequence, segment);
            if !self.settled[i] {
                let is_scaled = lanes.is_scaled();
                if lanes.is_negligible(self.smallest) {
                    lanes.raise();
                    is_skipped[i] = true;
                    continue;
                }
                if is_scaled {
                    lanes.clear_scaled(steps.len(), first, tile);
                    lanes.raise();
                }
                self.settled[i] = !is_scaled;
            }
            used = range.end;
        }
        let blocks = (0..used).step_by(RINGS).zip(is_skipped);
        for (first, _) in blocks.filter(|(_, is_skipped)| *is_skipped) {
            for row in tile.chunks_exact_mut(T::CHUNK).take(steps.len()) {
                row[first..used.min(first + RINGS)].fill(T::of(0.0));
            }
        }
        used
    }
}

/// Memory of [`Walk`].
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    value: ChunkColumn,
    other: ChunkColumn,
    scale: ChunkColumn,
    /// Whether all lanes of a block have the scale 0 and some was significant before.
    settled: [bool; MAX_CHUNK / RINGS],
}

#[derive(Clone, Debug)]
#[repr(align(64))]
struct ChunkColumn([f64; MAX_CHUNK]);

impl Default for ChunkColumn {
    fn default() -> Self {
        Self([0.0; MAX_CHUNK])
    }
}

/// Lanes that pass through the recurrence together.
struct Block<'a> {
    argument: &'a [f64],
    value: &'a mut [f64],
    other: &'a mut [f64],
    scale: &'a mut [f64],
}

impl Block<'_> {
    /// Returns whether the values of all lanes are below `smallest` or have a scale below 0.
    ///
    /// Values of lanes that are not significant grow, so that those after a segment bound those in
    /// it, and those of a scale below 0 remain negligible in a segment; see [`Scale`].
    #[inline(always)]
    fn is_negligible(&self, smallest: f64) -> bool {
        let lanes = self.value.iter().zip(&*self.other).zip(&*self.scale);
        lanes.fold(true, |negligible, ((value, other), &scale)| {
            // False for NaN.
            let is_small = (value.abs() < smallest) & (other.abs() < smallest);
            negligible & (is_small | (scale < 0.0))
        })
    }

    #[inline(always)]
    fn is_scaled(&self) -> bool {
        self.scale.iter().fold(false, |scaled, &scale| scaled | (scale < 0.0))
    }

    /// Returns whether all lanes have a scale below 0 or no value, so that no value is significant
    /// in the next segment.
    #[inline(always)]
    fn are_all_scaled(&self) -> bool {
        let lanes = self.value.iter().zip(&*self.other).zip(&*self.scale);
        lanes.fold(true, |scaled, ((&value, &other), &scale)| {
            scaled & ((scale < 0.0) | ((value == 0.0) & (other == 0.0)))
        })
    }

    /// Runs the steps of a segment and, if `STORE`, stores the values before each from lane `start`
    /// of the tile on.
    #[inline(always)]
    fn run<S: Simd, T: Number, const DIFFERENCES: bool, const STORE: bool>(
        &mut self,
        simd: S,
        steps: &[Step],
        start: usize,
        tile: &mut [T],
    ) {
        let mut first = 0;
        while first + TOGETHER * S::F64_LANES <= self.value.len() {
            self.run_vectors::<S, T, TOGETHER, DIFFERENCES, STORE>(simd, first, steps, start, tile);
            first += TOGETHER * S::F64_LANES;
        }
        while first < self.value.len() {
            self.run_vectors::<S, T, 1, DIFFERENCES, STORE>(simd, first, steps, start, tile);
            first += S::F64_LANES;
        }
    }

    #[inline(always)]
    fn run_vectors<
        S: Simd,
        T: Number,
        const K: usize,
        const DIFFERENCES: bool,
        const STORE: bool,
    >(
        &mut self,
        simd: S,
        first: usize,
        steps: &[Step],
        start: usize,
        tile: &mut [T],
    ) {
        let argument: [S::f64s; K] = load::<S, f64, K>(&self.argument[first..]);
        let mut value: [S::f64s; K] = load::<S, f64, K>(&self.value[first..]);
        let mut other: [S::f64s; K] = load::<S, f64, K>(&self.other[first..]);
        for (&Step(one, two), row) in steps.iter().zip(tile.chunks_exact_mut(T::CHUNK)) {
            if STORE {
                T::store::<S, K>(value, &mut row[start + first..][..K * S::F64_LANES]);
            }
            let (one, two) = (simd.splat_f64s(one), simd.splat_f64s(two));
            for k in 0..K {
                if DIFFERENCES {
                    let forced = simd.mul_f64s(one, argument[k]);
                    other[k] = simd.negate_mul_add_e_f64s(forced, value[k], other[k]);
                    value[k] = simd.mul_add_e_f64s(two, other[k], value[k]);
                } else {
                    let factor = simd.mul_add_e_f64s(one, argument[k], two);
                    let next = simd.mul_add_e_f64s(factor, value[k], other[k]);
                    (other[k], value[k]) = (value[k], next);
                }
            }
        }
        f64::vectors_mut::<S>(&mut self.value[first..])[..K].copy_from_slice(&value);
        f64::vectors_mut::<S>(&mut self.other[first..])[..K].copy_from_slice(&other);
    }

    /// Applies the factors at the end of a segment.
    #[inline(always)]
    fn rescale<const DIFFERENCES: bool>(&mut self, sequence: &Sequence, segment: usize) {
        if DIFFERENCES {
            let factors = sequence.factors[segment];
            for (value, difference) in self.value.iter_mut().zip(&mut *self.other) {
                *value *= factors.value;
                *difference *= factors.difference;
            }
        }
    }

    /// Moves lanes whose values have grown enough to the next scales.
    #[inline(always)]
    fn raise(&mut self) {
        let lanes = self.value.iter_mut().zip(&mut *self.other).zip(&mut *self.scale);
        for ((value, other), scale) in lanes {
            while *scale < 0.0 && value.abs().max(other.abs()) > Scale::LIMIT {
                *value *= Scale::DOWN;
                *other *= Scale::DOWN;
                *scale += 1.0;
            }
        }
    }

    /// Sets the stored values of lanes with a scale below 0 to zero.
    #[inline(always)]
    fn clear_scaled<T: Number>(&self, n_steps: usize, start: usize, tile: &mut [T]) {
        for (lane, _) in self.scale.iter().enumerate().filter(|(_, scale)| **scale < 0.0) {
            for row in tile.chunks_exact_mut(T::CHUNK).take(n_steps) {
                row[start + lane] = T::of(0.0);
            }
        }
    }
}
