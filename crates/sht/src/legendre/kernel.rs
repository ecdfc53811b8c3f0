use std::ops::Range;

use num_complex::Complex;
use pulp::bytemuck::cast_slice;
use pulp::{Arch, Simd, WithSimd};
use sphvar_nufft::parts::{SHORT, add_with_rests, magnitude};
use sphvar_sh::Alm;

use super::lanes::{Group, Scale};
use super::number::Number;
use super::order::{SPAN, Sequence, Step};
use super::{Arithmetic, FUNCTIONS, Form, Lanes, Order, PARTS, RINGS};

/// Number of vectors that pass through the recurrence together, to hide its latency.
const TOGETHER: usize = 4;

/// Number of degrees or vectors of rings whose sums are in registers together.
const ROWS: usize = 2;

/// Number of segments over which sums over degrees are in the type of the values.
const SEGMENTS: usize = 4;

/// Bytes.
const CACHE_LINE: usize = 64;

/// The largest number of lanes of a chunk.
const MAX_CHUNK: usize = 256;

/// Adjoint at one order: ring values of up to `FUNCTIONS` functions to their coefficients.
pub(crate) struct Adjoint<'a, 'c> {
    pub(crate) lanes: &'a Lanes,
    pub(crate) order: &'a Order,
    pub(crate) m: usize,
    /// Function b on ring r at `b * n_rings + r`.
    pub(crate) values: &'a [Complex<f64>],
    pub(crate) scratch: &'a mut Columns,
    /// The coefficients of order m of each function.
    pub(crate) outs: &'a mut [&'c mut [Complex<f64>]],
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

/// Workspace: the factors and the product.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    single: Buffers<f32>,
    double: Buffers<f64>,
    sums: Sums,
}

/// The part of the workspace that depends on the number type.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers<T> {
    /// The terms that the adjoint sums over lanes; see [`Group::gather`].
    by_lane: Aligned<T>,
    /// The terms that synthesis sums over degrees: `PARTS` numbers for each degree and function.
    by_degree: Vec<T>,
    /// Values of the recurrence, indexed by degree within a segment and by lane within a chunk.
    tile: Aligned<T>,
    /// Sums over the degrees of some segments.
    partial: Aligned<T>,
}

/// Sums in f64.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    /// Sums over lanes, indexed by form: `PARTS` numbers for each degree and function.
    by_degree: [Vec<f64>; 4],
    /// Those of all forms together.
    total: Vec<f64>,
    /// Sums over degrees, arranged like `by_lane`.
    by_lane: Vec<f64>,
    long: LongSums,
    state: State,
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

/// Numbers at the start of a cache line, so that no vector crosses the end of one.
#[derive(Clone, Debug, Default)]
struct Aligned<T>(Vec<T>);

impl<T: Number> Aligned<T> {
    /// Returns `len` numbers of unspecified values.
    #[inline(always)]
    fn numbers(&mut self, len: usize) -> &mut [T] {
        let slack = CACHE_LINE / size_of::<T>();
        self.0.resize(self.0.len().max(len + slack), T::of(0.0));
        let start = self.0.as_ptr().align_offset(CACHE_LINE).min(slack);
        &mut self.0[start..start + len]
    }
}

impl Columns {
    pub(super) fn single(&mut self) -> (&mut Buffers<f32>, &mut Sums) {
        (&mut self.single, &mut self.sums)
    }

    pub(super) fn double(&mut self) -> (&mut Buffers<f64>, &mut Sums) {
        (&mut self.double, &mut self.sums)
    }
}

impl Adjoint<'_, '_> {
    #[inline(never)]
    pub(crate) fn run(self, arch: Arch) {
        debug_assert!(self.outs.len() <= FUNCTIONS, "one group of functions");
        arch.dispatch(self);
    }

    #[inline(always)]
    fn sum_lanes<S: Simd, T: Number, const DIFFERENCES: bool>(&mut self, simd: S, form: Form) {
        let Self { lanes, order, m, values, ref mut scratch, .. } = *self;
        let n_functions = self.outs.len();
        let group = lanes.group(form);
        let product = Product { group, order, form, arithmetic: lanes.arithmetic() };
        let (Buffers { by_lane, tile, .. }, sums) = T::buffers(scratch);
        let Sums { by_degree, long, state, .. } = sums;
        let tile = tile.numbers(SPAN * T::CHUNK);
        let active = group.active(m);
        let terms = by_lane.numbers(group.column_len() * PARTS * n_functions);
        group.gather(values, lanes.n_rings(), active, terms);
        let sums = &mut by_degree[form as usize];
        sums.clear();
        sums.resize(order.len() * PARTS * n_functions, 0.0);
        let n_parts = active.div_ceil(RINGS * SHORT);
        if n_parts > 1 {
            long.clear(sums.len());
        }
        for first in (0..n_parts).rev().map(|part| part * RINGS * SHORT) {
            let lanes = first..active.min(first + RINGS * SHORT);
            product.adjoint::<S, T, DIFFERENCES>(simd, lanes, terms, state, tile, sums);
            if n_parts > 1 {
                long.flush(sums);
            }
        }
        if n_parts > 1 {
            long.write(sums);
        }
    }
}

impl WithSimd for Adjoint<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let arithmetic = self.lanes.arithmetic();
        if arithmetic.uses(Form::Equator) {
            self.sum_lanes::<S, f64, true>(simd, Form::Equator);
            self.sum_lanes::<S, f64, true>(simd, Form::Pole);
        }
        if arithmetic.uses(Form::Middle) {
            self.sum_lanes::<S, f64, false>(simd, Form::Middle);
        }
        if arithmetic.uses(Form::Single) {
            self.sum_lanes::<S, f32, false>(simd, Form::Single);
        }
        let Sums { by_degree, total, .. } = &mut self.scratch.sums;
        self.order.collect(arithmetic, by_degree, total, self.outs);
    }
}

impl Synthesis<'_> {
    #[inline(never)]
    pub(crate) fn run(self, arch: Arch) {
        debug_assert!(self.alms.len() <= FUNCTIONS, "one group of functions");
        arch.dispatch(self);
    }

    #[inline(always)]
    fn sum_degrees<S: Simd, T: Number, const DIFFERENCES: bool>(&mut self, simd: S, form: Form) {
        let Self { lanes, order, m, alms, ref mut scratch, ref mut values } = *self;
        let n_functions = alms.len();
        let group = lanes.group(form);
        let product = Product { group, order, form, arithmetic: lanes.arithmetic() };
        let (Buffers { by_degree, tile, partial, .. }, sums) = T::buffers(scratch);
        let Sums { by_lane, state, .. } = sums;
        by_degree.resize(order.len() * PARTS * n_functions, T::of(0.0));
        // Coefficients may be out of the range of f32.
        let mut sizes = [1.0; FUNCTIONS];
        for (function, (alm, size)) in alms.iter().zip(&mut sizes).enumerate() {
            let column = alm.column(m);
            *size = magnitude(column.iter().flat_map(|a| [a.re, a.im]));
            order.distribute(form, column, *size, n_functions, function, by_degree);
        }
        let partial = partial.numbers(n_functions * PARTS * T::CHUNK);
        let tile = tile.numbers(SPAN * T::CHUNK);
        by_lane.clear();
        by_lane.resize(group.column_len() * PARTS * n_functions, 0.0);
        let buffers = (state, tile, partial);
        product.synthesis::<S, T, DIFFERENCES>(simd, group.active(m), by_degree, buffers, by_lane);
        group.scatter(by_lane, &sizes, lanes.n_rings(), values);
    }
}

impl WithSimd for Synthesis<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let arithmetic = self.lanes.arithmetic();
        if arithmetic.uses(Form::Equator) {
            self.sum_degrees::<S, f64, true>(simd, Form::Equator);
            self.sum_degrees::<S, f64, true>(simd, Form::Pole);
        }
        if arithmetic.uses(Form::Middle) {
            self.sum_degrees::<S, f64, false>(simd, Form::Middle);
        }
        if arithmetic.uses(Form::Single) {
            self.sum_degrees::<S, f32, false>(simd, Form::Single);
        }
    }
}

/// Products of the matrix of recurrence values `v_n(r)`, for lanes r of one form, with columns.
#[derive(Clone, Copy)]
struct Product<'a> {
    group: &'a Group,
    order: &'a Order,
    form: Form,
    arithmetic: Arithmetic,
}

impl Product<'_> {
    /// Adds `sum_r v_n(r) terms[c][r]` over a range of lanes, which starts at a multiple of
    /// `RINGS`, to `sums[n][c]`.
    #[inline(always)]
    fn adjoint<S: Simd, T: Number, const DIFFERENCES: bool>(
        self,
        simd: S,
        lanes: Range<usize>,
        terms: &[T],
        state: &mut State,
        tile: &mut [T],
        sums: &mut [f64],
    ) {
        let columns_len = self.group.column_len() * PARTS;
        let n_functions = terms.len() / columns_len;
        let sums = sums.as_chunks_mut::<PARTS>().0;
        // Towards the equator, where terms are largest if their sizes differ.
        for first in lanes.clone().step_by(T::CHUNK).rev() {
            let chunk = first..lanes.end.min(first + T::CHUNK);
            let mut walk = Walk::start::<T>(self, chunk, state);
            for (segment, steps) in walk.sequence.steps.chunks(SPAN).enumerate() {
                let used = walk.advance::<S, T, DIFFERENCES>(simd, segment, steps, tile);
                if used == 0 {
                    continue;
                }
                for (function, terms) in terms.chunks_exact(columns_len).enumerate() {
                    let column = |part: usize| {
                        T::vectors::<S>(&terms[part * self.group.column_len() + first..][..used])
                    };
                    let columns = [column(0), column(1), column(2), column(3)];
                    for n in (0..steps.len()).step_by(ROWS) {
                        let row = |n: usize| T::vectors::<S>(&tile[n * T::CHUNK..][..used]);
                        let products = over_lanes::<S, T>(simd, [row(n), row(n + 1)], columns);
                        for (n, product) in (n..steps.len()).zip(products) {
                            let product = fold::<S, T>(simd, product);
                            let sums = &mut sums[(segment * SPAN + n) * n_functions + function];
                            for part in 0..PARTS {
                                sums[part] += product[part];
                            }
                        }
                    }
                }
            }
        }
    }

    /// Adds `sum_n v_n(r) terms[n][c]` to `values[c][r]` for the first `active` lanes.
    #[inline(always)]
    fn synthesis<S: Simd, T: Number, const DIFFERENCES: bool>(
        self,
        simd: S,
        active: usize,
        terms: &[T],
        (state, tile, partial): (&mut State, &mut [T], &mut [T]),
        values: &mut [f64],
    ) {
        let columns_len = self.group.column_len() * PARTS;
        let n_functions = values.len() / columns_len;
        let terms = terms.as_chunks::<PARTS>().0;
        for first in (0..active).step_by(T::CHUNK) {
            let chunk = first..active.min(first + T::CHUNK);
            partial.fill(T::of(0.0));
            let mut walk = Walk::start::<T>(self, chunk, state);
            for (segment, steps) in walk.sequence.steps.chunks(SPAN).enumerate() {
                let used = walk.advance::<S, T, DIFFERENCES>(simd, segment, steps, tile);
                if used > 0 {
                    for function in 0..n_functions {
                        let start = segment * SPAN * n_functions + function;
                        let terms = Terms { terms: &terms[start..], step: n_functions };
                        let columns = &mut partial[function * PARTS * T::CHUNK..];
                        over_degrees::<S, T>(simd, terms, tile, steps.len(), used, columns);
                    }
                }
                if (segment + 1).is_multiple_of(SEGMENTS) {
                    flush(partial, first, self.group.column_len(), values);
                }
            }
            flush(partial, first, self.group.column_len(), values);
        }
    }
}

/// Adds the partial sums of a chunk of lanes to `values`, and sets them to zero.
#[inline(always)]
fn flush<T: Number>(partial: &mut [T], first: usize, column_len: usize, values: &mut [f64]) {
    let columns = values.chunks_exact_mut(column_len);
    for (values, partial) in columns.zip(partial.chunks_exact_mut(T::CHUNK)) {
        for (value, part) in values[first..].iter_mut().zip(partial) {
            *value += part.to_f64();
            *part = T::of(0.0);
        }
    }
}

/// The terms of one function in sums over degrees.
#[derive(Clone, Copy)]
struct Terms<'a, T> {
    terms: &'a [[T; PARTS]],
    step: usize,
}

/// The recurrence at the lanes of a chunk, segment by segment.
struct Walk<'a> {
    sequence: &'a Sequence,
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
    fn start<T: Number>(product: Product<'a>, lanes: Range<usize>, state: &'a mut State) -> Self {
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
    fn advance<S: Simd, T: Number, const DIFFERENCES: bool>(
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

/// Returns `sum_r rows[i][r] columns[c][r]` for each i and c, as vectors of partial sums.
#[inline(always)]
fn over_lanes<S: Simd, T: Number>(
    simd: S,
    rows: [&[T::Vector<S>]; ROWS],
    columns: [&[T::Vector<S>]; PARTS],
) -> [[T::Vector<S>; PARTS]; ROWS] {
    let mut sums = [[T::splat(simd, T::of(0.0)); PARTS]; ROWS];
    let [a, b, c, d] = columns;
    let terms = a.iter().zip(b).zip(c.iter().zip(d));
    for ((&one, &other), ((&a, &b), (&c, &d))) in rows[0].iter().zip(rows[1]).zip(terms) {
        let (values, terms) = ([one, other], [a, b, c, d]);
        for i in 0..ROWS {
            for part in 0..PARTS {
                sums[i][part] = T::mul_add(simd, values[i], terms[part], sums[i][part]);
            }
        }
    }
    sums
}

/// Returns the sum of each of four vectors.
#[inline(always)]
fn fold<S: Simd, T: Number>(simd: S, sums: [T::Vector<S>; PARTS]) -> [f64; PARTS] {
    let turns = T::interleave(simd, sums);
    let mut total = [0.0; PARTS];
    if size_of::<T::Vector<S>>() >= PARTS * size_of::<T>() {
        let [a, b, c, d] = turns;
        let sum = T::add(simd, T::add(simd, a, b), T::add(simd, c, d));
        add_turns::<T>(cast_slice(std::slice::from_ref(&sum)), &mut total);
    } else {
        add_turns::<T>(cast_slice(&turns), &mut total);
    }
    total
}

#[inline(always)]
fn add_turns<T: Number>(numbers: &[T], total: &mut [f64; PARTS]) {
    for turn in numbers.as_chunks::<PARTS>().0 {
        for part in 0..PARTS {
            total[part] += turn[part].to_f64();
        }
    }
}

/// Adds `sum_n tile[n][r] terms[n][c]`, for n below `n_steps`, to `columns[c][r]` for the first
/// `used` lanes r.
#[inline(always)]
fn over_degrees<S: Simd, T: Number>(
    simd: S,
    terms: Terms<'_, T>,
    tile: &[T],
    n_steps: usize,
    used: usize,
    columns: &mut [T],
) {
    let lanes = size_of::<T::Vector<S>>() / size_of::<T>();
    let mut first = 0;
    while first + ROWS * lanes <= used {
        over_degrees_at::<S, T, ROWS>(simd, terms, tile, n_steps, first, columns);
        first += ROWS * lanes;
    }
    while first < used {
        over_degrees_at::<S, T, 1>(simd, terms, tile, n_steps, first, columns);
        first += lanes;
    }
}

/// [`over_degrees`] for `K` vectors of lanes from `first`.
#[inline(always)]
fn over_degrees_at<S: Simd, T: Number, const K: usize>(
    simd: S,
    Terms { terms, step }: Terms<'_, T>,
    tile: &[T],
    n_steps: usize,
    first: usize,
    columns: &mut [T],
) {
    let mut sums = [[T::splat(simd, T::of(0.0)); K]; PARTS];
    for part in 0..PARTS {
        sums[part] = load::<S, T, K>(&columns[part * T::CHUNK + first..]);
    }
    for n in 0..n_steps {
        let values: [T::Vector<S>; K] = load::<S, T, K>(&tile[n * T::CHUNK + first..]);
        let terms = &terms[n * step];
        for part in 0..PARTS {
            let term = T::splat(simd, terms[part]);
            for k in 0..K {
                sums[part][k] = T::mul_add(simd, values[k], term, sums[part][k]);
            }
        }
    }
    for part in 0..PARTS {
        let column = T::vectors_mut::<S>(&mut columns[part * T::CHUNK + first..]);
        column[..K].copy_from_slice(&sums[part]);
    }
}

/// Memory of [`Walk`].
#[derive(Clone, Debug, Default)]
struct State {
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

#[inline(always)]
fn load<S: Simd, T: Number, const K: usize>(from: &[T]) -> [T::Vector<S>; K] {
    let vectors = T::vectors::<S>(&from[..K * (size_of::<T::Vector<S>>() / size_of::<T>())]);
    std::array::from_fn(|k| vectors[k])
}
