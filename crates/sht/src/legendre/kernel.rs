//! Products of one order with the matrix of Legendre functions, in both directions: the recurrence
//! fills a tile of values ([`walk`]), which [`product`] multiplies with the terms of the functions.

mod buffers;
mod product;
mod walk;

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};
use sphvar_nufft::parts::{SHORT, magnitude};
use sphvar_sh::Alm;

pub(crate) use buffers::Columns;
pub(super) use buffers::{Buffers, Sums};
use product::Product;

use super::number::Number;
use super::order::SPAN;
use super::{FUNCTIONS, Form, Lanes, Order, PARTS, RINGS};

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
