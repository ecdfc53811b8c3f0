use std::ops::Range;

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};
use sphvar_nufft::parts::{SHORT, add_with_rests};
use sphvar_sh::Alm;

use super::lanes::{Group, ValueRange};
use super::order::{Factors, SPAN, Segment, Step};
use super::{Anchor, FUNCTIONS, Lanes, Order, PARTS, RINGS};

/// Values of the recurrence, indexed by n within a segment and by ring.
type Tile = [[f64; RINGS]; SPAN];

/// Number of n that sums over rings process together.
pub(crate) const ROWS: usize = 8;

/// Number of vectors that pass through the recurrence together, to hide its latency.
const TOGETHER: usize = 4;

/// Adjoint at one order: ring values of up to `FUNCTIONS` functions to their coefficients.
pub(crate) struct Adjoint<'a, 'o> {
    pub(crate) lanes: &'a Lanes,
    pub(crate) order: &'a Order,
    pub(crate) m: usize,
    /// Function b on ring r at `b * n_rings + r`.
    pub(crate) values: &'a [Complex<f64>],
    pub(crate) scratch: &'a mut Columns,
    /// The coefficients of this order of each function.
    pub(crate) outs: &'a mut [&'o mut [Complex<f64>]],
}

/// Synthesis at one order: coefficients to ring values.
pub(crate) struct Synthesis<'a> {
    pub(crate) lanes: &'a Lanes,
    pub(crate) order: &'a Order,
    pub(crate) m: usize,
    pub(crate) alms: &'a [&'a Alm],
    pub(crate) scratch: &'a mut Columns,
    pub(crate) values: &'a mut [Complex<f64>],
}

/// Workspace: the factors and the product, indexed by anchor. A row has `PARTS` columns per
/// function, for 1 or for `FUNCTIONS` functions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    by_lane: [Vec<f64>; 2],
    by_degree: [Vec<f64>; 2],
    long: LongSums,
}

/// Sums over rings that are too long for a single partial sum.
#[derive(Clone, Debug, Default)]
struct LongSums {
    sums: Vec<f64>,
    rests: Vec<f64>,
}

impl LongSums {
    fn clear(&mut self, len: usize) {
        for column in [&mut self.sums, &mut self.rests] {
            column.clear();
            column.resize(len, 0.0);
        }
    }

    /// Adds partial sums and sets them to zero. In one long sum all rounding errors can have the
    /// same sign.
    #[inline(always)]
    fn flush(&mut self, short: &mut [f64]) {
        add_with_rests(&mut self.sums, &mut self.rests, short);
        short.fill(0.0);
    }

    fn write(&self, out: &mut [f64]) {
        for (out, (sum, rest)) in out.iter_mut().zip(self.sums.iter().zip(&self.rests)) {
            *out = sum + rest;
        }
    }
}

impl Adjoint<'_, '_> {
    pub(crate) fn run(self, arch: Arch) {
        dispatch(arch, self.outs.len(), self);
    }
}

impl Synthesis<'_> {
    pub(crate) fn run(self, arch: Arch) {
        dispatch(arch, self.alms.len(), self);
    }
}

/// Returns the number of columns for a group of functions.
fn n_columns(n_functions: usize) -> usize {
    if n_functions == 1 { PARTS } else { FUNCTIONS * PARTS }
}

/// Dispatches to the widest vectors whose length divides the number of columns.
fn dispatch(arch: Arch, n_functions: usize, op: impl WithSimd<Output = ()>) {
    debug_assert!(n_functions <= FUNCTIONS, "one group of functions");
    #[cfg(target_arch = "x86_64")]
    if let Arch::V4(simd) = arch
        && n_functions == 1
    {
        return Simd::vectorize(*simd, op);
    }
    arch.dispatch(op);
}

impl WithSimd for Adjoint<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, order, m, values, scratch, outs } = self;
        let Columns { by_lane, by_degree, long } = scratch;
        let n_columns = n_columns(outs.len());
        lanes.gather(values, n_columns, by_lane);
        for (anchor, (terms, sums)) in
            Anchor::BOTH.into_iter().zip(by_lane.iter().zip(&mut *by_degree))
        {
            sums.clear();
            sums.resize((order.len() + ROWS) * n_columns, 0.0);
            let group = lanes.group(anchor);
            let product = Product { group, order, anchor, m };
            let active = group.active(m);
            let n_parts = active.div_ceil(RINGS * SHORT);
            if n_parts > 1 {
                long.clear(sums.len());
            }
            for first in (0..n_parts).rev().map(|part| part * RINGS * SHORT) {
                let lanes = first..active.min(first + RINGS * SHORT);
                match n_columns / S::F64_LANES {
                    1 => product.adjoint::<S, 1, 8>(simd, lanes, terms, sums),
                    2 => product.adjoint::<S, 2, 8>(simd, lanes, terms, sums),
                    4 => product.adjoint::<S, 4, 2>(simd, lanes, terms, sums),
                    8 => product.adjoint::<S, 8, 2>(simd, lanes, terms, sums),
                    _ => product.adjoint::<S, 16, 1>(simd, lanes, terms, sums),
                }
                if n_parts > 1 {
                    long.flush(sums);
                }
            }
            if n_parts > 1 {
                long.write(sums);
            }
        }
        for (function, out) in outs.iter_mut().enumerate() {
            order.collect(by_degree, n_columns, function, out);
        }
    }
}

impl WithSimd for Synthesis<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, order, m, alms, scratch, values } = self;
        let Columns { by_lane, by_degree, .. } = scratch;
        let n_columns = n_columns(alms.len());
        for terms in &mut *by_degree {
            terms.clear();
            terms.resize(order.len() * n_columns, 0.0);
        }
        for (function, alm) in alms.iter().enumerate() {
            order.distribute(alm.column(m), n_columns, function, by_degree);
        }
        for (anchor, (values, terms)) in
            Anchor::BOTH.into_iter().zip(by_lane.iter_mut().zip(&*by_degree))
        {
            let group = lanes.group(anchor);
            values.clear();
            values.resize(group.capacity() * n_columns, 0.0);
            let product = Product { group, order, anchor, m };
            match n_columns / S::F64_LANES {
                1 => product.synthesis::<S, 1, 8>(simd, terms, values),
                2 => product.synthesis::<S, 2, 8>(simd, terms, values),
                4 => product.synthesis::<S, 4, 2>(simd, terms, values),
                8 => product.synthesis::<S, 8, 2>(simd, terms, values),
                _ => product.synthesis::<S, 16, 1>(simd, terms, values),
            }
        }
        lanes.scatter(by_lane, n_columns, values);
    }
}

/// Products of the matrix of recurrence values `v_n(r)`, for lanes r of one anchor, with columns c
/// stored as `V` vectors.
#[derive(Clone, Copy)]
struct Product<'a> {
    group: &'a Group,
    order: &'a Order,
    anchor: Anchor,
    m: usize,
}

impl Product<'_> {
    /// Adds `sum_r v_n(r) terms[r][c]` over a range of lanes, which starts at a multiple of
    /// `RINGS`, to `sums[n][c]`, for `N` degrees at a time.
    #[inline(always)]
    fn adjoint<S: Simd, const V: usize, const N: usize>(
        self,
        simd: S,
        lanes: Range<usize>,
        terms: &[f64],
        sums: &mut [f64],
    ) {
        let (terms, _) = S::as_simd_f64s(terms);
        let (sums, _) = S::as_mut_simd_f64s(sums);
        let mut tile: Tile = [[0.0; RINGS]; SPAN];
        for first in lanes.clone().step_by(RINGS).rev() {
            let count = RINGS.min(lanes.end - first);
            let terms = terms[first * V..(first + count) * V].as_chunks::<V>().0;
            self.walk(simd, first..first + count, &mut tile, &mut |simd, n, tile| {
                let padded = n.len().next_multiple_of(ROWS);
                let sums = sums[n.start * V..(n.start + padded) * V].as_chunks_mut::<V>().0;
                let sums = sums.as_chunks_mut::<N>().0;
                for (rows, sums) in tile.as_chunks::<N>().0.iter().zip(sums) {
                    over_rings(simd, rows, terms, sums);
                }
            });
        }
    }

    /// Adds `sum_n v_n(r) terms[n][c]` to `values[r][c]`, for `N` rings at a time.
    #[inline(always)]
    fn synthesis<S: Simd, const V: usize, const N: usize>(
        self,
        simd: S,
        terms: &[f64],
        values: &mut [f64],
    ) {
        let (terms, _) = S::as_simd_f64s(terms);
        let (values, _) = S::as_mut_simd_f64s(values);
        let active = self.group.active(self.m);
        let mut tile: Tile = [[0.0; RINGS]; SPAN];
        for first in (0..active).step_by(RINGS) {
            let count = RINGS.min(active - first);
            // Lanes are padded to whole blocks, so there are whole groups of N.
            let padded = count.next_multiple_of(N);
            let values = values[first * V..(first + padded) * V].as_chunks_mut::<V>().0;
            self.walk(simd, first..first + count, &mut tile, &mut |simd, n, tile| {
                let terms = terms[n.start * V..n.end * V].as_chunks::<V>().0;
                for (group, values) in values.as_chunks_mut::<N>().0.iter_mut().enumerate() {
                    over_degrees(simd, tile, group * N, terms, values);
                }
            });
        }
    }

    /// Computes all degrees for up to `RINGS` lanes of a group. Calls `consume` with the values and
    /// the range of n of each segment in which any lane is significant. Rows of the tile beyond the
    /// range, up to a multiple of `ROWS`, are zero.
    #[inline(always)]
    fn walk<S: Simd>(
        self,
        simd: S,
        lanes: Range<usize>,
        tile: &mut Tile,
        consume: &mut impl FnMut(S, Range<usize>, &Tile),
    ) {
        let Self { group, order, anchor, .. } = self;
        let count = lanes.len();
        let block = lanes.start..lanes.start + RINGS;
        let mut lane = Block {
            // The lanes that pad the last group of synthesis are also written, with zeros.
            n_vectors: count.next_multiple_of(ROWS).div_ceil(S::F64_LANES),
            argument: [0.0; RINGS],
            value: [0.0; RINGS],
            difference: [0.0; RINGS],
            scale: [0.0; RINGS],
        };
        lane.argument.copy_from_slice(&group.argument[block.clone()]);
        lane.value.copy_from_slice(&group.start[block.clone()]);
        lane.scale.copy_from_slice(&group.scale[block]);
        // Padding lanes must not affect decisions: their number depends on the width of vectors and
        // thereby on the number of functions.
        lane.value[count..].fill(0.0);
        lane.scale[count..].fill(0.0);
        let mut start = 0;
        let mut has_scaled = lane.scale.iter().any(|&scale| scale < 0.0);
        let sequence = order.sequence(anchor);
        for (&Segment { end, growth }, factors) in order.segments().iter().zip(&sequence.factors) {
            let steps = &sequence.steps[start..end];
            if has_scaled && lane.is_negligible(growth, group.range) {
                lane.run::<S, false>(simd, steps, tile);
            } else {
                lane.run::<S, true>(simd, steps, tile);
                let padded = steps.len().next_multiple_of(ROWS);
                tile[steps.len()..padded].fill([0.0; RINGS]);
                if has_scaled {
                    lane.unscale(simd, &mut tile[..steps.len()], group.range);
                }
                consume(simd, start..end, tile);
            }
            lane.rescale(factors);
            if has_scaled {
                lane.raise_scales(group.range);
                has_scaled = lane.scale.iter().any(|&scale| scale < 0.0);
            }
            start = end;
        }
    }
}

/// Number of rings added per iteration without a bounds check.
const UNROLLED: usize = 8;

/// Computes `sums[i] += sum_r rows[i][r] terms[r]`.
#[inline(always)]
fn over_rings<S: Simd, const V: usize, const N: usize>(
    simd: S,
    rows: &[[f64; RINGS]; N],
    terms: &[[S::f64s; V]],
    sums: &mut [[S::f64s; V]; N],
) {
    let mut local = [[simd.splat_f64s(0.0); V]; N];
    // Towards the equator, where terms are largest if their sizes differ.
    let (chunks, rest) = terms.as_chunks::<UNROLLED>();
    for (r, term) in (chunks.len() * UNROLLED..RINGS).zip(rest).rev() {
        add_ring(simd, rows, r, term, &mut local);
    }
    for (first, chunk) in (0..RINGS).step_by(UNROLLED).zip(chunks).rev() {
        for r in (0..UNROLLED).rev() {
            add_ring(simd, rows, first + r, &chunk[r], &mut local);
        }
    }
    for i in 0..N {
        for v in 0..V {
            sums[i][v] = simd.add_f64s(sums[i][v], local[i][v]);
        }
    }
}

/// Computes `sums[i] += rows[i][r] term`.
#[inline(always)]
fn add_ring<S: Simd, const V: usize, const N: usize>(
    simd: S,
    rows: &[[f64; RINGS]; N],
    r: usize,
    term: &[S::f64s; V],
    sums: &mut [[S::f64s; V]; N],
) {
    for i in 0..N {
        let value = simd.splat_f64s(rows[i][r]);
        for v in 0..V {
            sums[i][v] = simd.mul_add_e_f64s(value, term[v], sums[i][v]);
        }
    }
}

/// Computes `values[i] += sum_n tile[n][first + i] terms[n]` over all terms.
#[inline(always)]
fn over_degrees<S: Simd, const V: usize, const N: usize>(
    simd: S,
    tile: &Tile,
    first: usize,
    terms: &[[S::f64s; V]],
    values: &mut [[S::f64s; V]; N],
) {
    let mut local = *values;
    for (row, term) in tile.iter().zip(terms) {
        let row: &[f64; N] = row[first..].first_chunk().unwrap_or(&[0.0; N]);
        for i in 0..N {
            let value = simd.splat_f64s(row[i]);
            for v in 0..V {
                local[i][v] = simd.mul_add_e_f64s(value, term[v], local[i][v]);
            }
        }
    }
    *values = local;
}

/// Lanes that pass through the recurrence together.
struct Block {
    n_vectors: usize,
    argument: [f64; RINGS],
    value: [f64; RINGS],
    difference: [f64; RINGS],
    scale: [f64; RINGS],
}

impl Block {
    /// Returns whether no lane becomes significant while values grow by `growth`.
    #[inline(always)]
    fn is_negligible(&self, growth: f64, range: ValueRange) -> bool {
        let lanes = self.value.iter().zip(&self.scale);
        // Lanes without a ring have the value 0.
        lanes.fold(true, |negligible, (value, &scale)| {
            negligible & ((scale < 0.0) & (value.abs() * growth < range.limit) | (*value == 0.0))
        })
    }

    /// Runs the steps of a segment; `STORE` selects whether values are stored.
    #[inline(always)]
    fn run<S: Simd, const STORE: bool>(&mut self, simd: S, steps: &[Step], tile: &mut Tile) {
        let mut vector = 0;
        while vector + TOGETHER <= self.n_vectors {
            self.run_vectors::<S, TOGETHER, STORE>(simd, vector, steps, tile);
            vector += TOGETHER;
        }
        while vector < self.n_vectors {
            self.run_vectors::<S, 1, STORE>(simd, vector, steps, tile);
            vector += 1;
        }
    }

    #[inline(always)]
    fn run_vectors<S: Simd, const K: usize, const STORE: bool>(
        &mut self,
        simd: S,
        first: usize,
        steps: &[Step],
        tile: &mut Tile,
    ) {
        let argument: [S::f64s; K] = load::<S, K>(&self.argument, first);
        let mut value: [S::f64s; K] = load::<S, K>(&self.value, first);
        let mut difference: [S::f64s; K] = load::<S, K>(&self.difference, first);
        for (step, row) in steps.iter().zip(tile) {
            if STORE {
                store::<S, K>(row, first, value);
            }
            let (forcing, follow) = (simd.splat_f64s(step.forcing), simd.splat_f64s(step.follow));
            for k in 0..K {
                let forced = simd.mul_f64s(forcing, argument[k]);
                difference[k] = simd.negate_mul_add_e_f64s(forced, value[k], difference[k]);
                value[k] = simd.mul_add_e_f64s(follow, difference[k], value[k]);
            }
        }
        store::<S, K>(&mut self.value, first, value);
        store::<S, K>(&mut self.difference, first, difference);
    }

    /// Applies the factors at the end of a segment.
    #[inline(always)]
    fn rescale(&mut self, factors: &Factors) {
        for (value, difference) in self.value.iter_mut().zip(&mut self.difference) {
            *value *= factors.value;
            *difference *= factors.difference;
        }
    }

    /// Moves lanes whose values have grown enough to the next scale.
    #[inline(always)]
    fn raise_scales(&mut self, range: ValueRange) {
        let lanes = self.value.iter_mut().zip(&mut self.difference).zip(&mut self.scale);
        for ((value, difference), scale) in lanes {
            if *scale < 0.0 && value.abs().max(difference.abs()) > range.limit {
                *value *= range.down;
                *difference *= range.down;
                *scale += 1.0;
            }
        }
    }

    /// Converts the values of lanes with a scale below 1 to the scale 1.
    #[inline(always)]
    fn unscale<S: Simd>(&self, simd: S, tile: &mut [[f64; RINGS]], range: ValueRange) {
        let mut factors = [0.0; RINGS];
        for (factor, &scale) in factors.iter_mut().zip(&self.scale) {
            let below = if scale < -1.0 { 0.0 } else { range.down };
            *factor = if scale < 0.0 { below } else { 1.0 };
        }
        let (factors, _) = S::as_simd_f64s(&factors);
        for row in tile {
            let (row, _) = S::as_mut_simd_f64s(row);
            for (value, factor) in row.iter_mut().zip(factors) {
                *value = simd.mul_f64s(*value, *factor);
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd, const K: usize>(from: &[f64; RINGS], first: usize) -> [S::f64s; K] {
    let (vectors, _) = S::as_simd_f64s(from);
    std::array::from_fn(|k| vectors[first + k])
}

#[inline(always)]
fn store<S: Simd, const K: usize>(to: &mut [f64; RINGS], first: usize, values: [S::f64s; K]) {
    let (vectors, _) = S::as_mut_simd_f64s(to);
    vectors[first..first + K].copy_from_slice(&values);
}
