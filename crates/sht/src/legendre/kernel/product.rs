use std::ops::Range;

use pulp::Simd;
use pulp::bytemuck::cast_slice;

use super::walk::{State, Walk};
use crate::legendre::lanes::Group;
use crate::legendre::number::{Number, load};
use crate::legendre::order::SPAN;
use crate::legendre::{Arithmetic, Form, Order, PARTS};

/// Number of degrees or vectors of rings whose sums are in registers together.
const ROWS: usize = 2;

/// Number of segments over which sums over degrees are in the type of the values.
const SEGMENTS: usize = 4;

/// Products of the matrix of recurrence values `v_n(r)`, for lanes r of one form, with columns.
#[derive(Clone, Copy)]
pub(super) struct Product<'a> {
    pub(super) group: &'a Group,
    pub(super) order: &'a Order,
    pub(super) form: Form,
    pub(super) arithmetic: Arithmetic,
}

impl Product<'_> {
    /// Adds `sum_r v_n(r) terms[c][r]` over a range of lanes, which starts at a multiple of
    /// `RINGS`, to `sums[n][c]`.
    #[inline(always)]
    pub(super) fn adjoint<S: Simd, T: Number, const DIFFERENCES: bool>(
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
    pub(super) fn synthesis<S: Simd, T: Number, const DIFFERENCES: bool>(
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
        let sum = T::add_vectors(simd, T::add_vectors(simd, a, b), T::add_vectors(simd, c, d));
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
