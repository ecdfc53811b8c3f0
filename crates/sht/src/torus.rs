use std::f64::consts::PI;
use std::ops::{AddAssign, Range};
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};
use rustfft::{Fft, FftPlanner};
use sphvar_nufft::parts::{Design, Real, good_size};
use sphvar_sh::Colatitude;

/// Orders whose columns are transformed at a time: a stretch of memory that one access brings in.
pub(crate) const ORDERS: usize = 8;

/// The Fourier transforms between a grid and the rings of the Legendre stage, both ways.
///
/// The sphere is laid twice on the torus, theta in [0, 2 pi), where a function of degree L is a
/// trigonometric polynomial: its column of order m is even about the poles for even m and odd for
/// odd m. Two rows of the grid, and two columns of unlike parity, share one complex transform.
///
/// The grid's values stand for those of the function by the window given; *spectra* are the Fourier
/// coefficients in phi of every row from pole to pole: by block of `ORDERS` orders, row, and order.
#[derive(Clone)]
pub(crate) struct Torus<T> {
    lmax: usize,
    n_theta: usize,
    n_phi: usize,
    /// Rings on the whole torus, an even number 2R > 2 lmax: ring r is at `theta = pi r/R`.
    n_rings: usize,
    /// One over the window's transform at each m, filled up to a multiple of `ORDERS` with zeros, and at
    /// each k from 0 (it is even in k).
    phi_correction: Box<[T]>,
    theta_correction: Box<[T]>,
    phi_forward: Arc<dyn Fft<T>>,
    phi_inverse: Arc<dyn Fft<T>>,
    theta_forward: Arc<dyn Fft<T>>,
    theta_inverse: Arc<dyn Fft<T>>,
    rings_forward: Arc<dyn Fft<T>>,
    rings_inverse: Arc<dyn Fft<T>>,
}

/// Scratch memory of [`Torus`].
#[derive(Debug, Default)]
pub(crate) struct TorusScratch<T> {
    pair: Vec<Complex<T>>,
    columns: Vec<Complex<T>>,
    rings: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

/// Where the numbers of a grid are: rows from the one `margin` beyond the north pole on, columns from
/// `margin` before phi = 0 on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub(crate) stride: usize,
    pub(crate) margin: usize,
}

impl<T: Real> Torus<T> {
    pub(crate) fn new(lmax: usize, design: Design) -> Self {
        let n = design.cells(lmax);
        // Each ring costs in the Legendre stage as well.
        let n_rings = good_size((2 * lmax + 2) as f64, 1.03);
        let mut correction: Vec<T> =
            design.window.transform(n, lmax).into_iter().map(|t| T::of(1.0 / t)).collect();
        let theta_correction = correction.clone().into();
        correction.resize((lmax + 1).next_multiple_of(ORDERS), T::default());
        let mut planner = FftPlanner::new();
        Self {
            lmax,
            n_theta: n,
            n_phi: n,
            n_rings,
            phi_correction: correction.into(),
            theta_correction,
            phi_forward: planner.plan_fft_forward(n),
            phi_inverse: planner.plan_fft_inverse(n),
            theta_forward: planner.plan_fft_forward(n),
            theta_inverse: planner.plan_fft_inverse(n),
            rings_forward: planner.plan_fft_forward(n_rings),
            rings_inverse: planner.plan_fft_inverse(n_rings),
        }
    }

    pub(crate) fn n_theta(&self) -> usize {
        self.n_theta
    }

    pub(crate) fn n_phi(&self) -> usize {
        self.n_phi
    }

    /// Rings from pole to pole, both included.
    pub(crate) fn n_ring_rows(&self) -> usize {
        self.n_rings / 2 + 1
    }

    pub(crate) fn colatitudes(&self) -> impl Iterator<Item = Colatitude> + use<T> {
        let half = self.n_rings / 2;
        (0..=half).map(move |r| ring_colatitude(r, half))
    }

    /// Rows of the grid from pole to pole, both included.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_theta / 2 + 1
    }

    /// The numbers that the spectra of one set or function take.
    pub(crate) fn spectra_len(&self) -> usize {
        self.n_rows() * self.phi_correction.len()
    }

    /// The block of the spectra with the orders from `first`.
    fn block(&self, first: usize) -> Range<usize> {
        let start = first * self.n_rows();
        start..start + ORDERS * self.n_rows()
    }

    /// Runs one stage.
    pub(crate) fn run(&self, arch: Arch, stage: Stage<'_, T>, scratch: &mut TorusScratch<T>) {
        arch.dispatch(Run { torus: self, stage, scratch });
    }

    fn prepare(&self, scratch: &mut TorusScratch<T>) {
        let ffts = [&self.phi_forward, &self.phi_inverse, &self.theta_forward, &self.theta_inverse];
        let ffts = ffts.into_iter().chain([&self.rings_forward, &self.rings_inverse]);
        let needed = ffts.map(|fft| fft.get_inplace_scratch_len()).max().unwrap_or(0);
        scratch.fft.resize(needed.max(scratch.fft.len()), Complex::default());
        scratch.pair.resize(self.n_phi + 1, Complex::default());
        scratch.columns.resize(self.n_theta * ORDERS / 2, Complex::default());
        scratch.rings.resize(self.n_rings * ORDERS / 2, Complex::default());
    }

    /// The spectra of a grid that points were spread on; uses the grid up.
    #[inline(always)]
    fn analyse_rows(
        &self,
        grid: &mut [T],
        layout: Layout,
        spectra: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        self.fold(grid, layout);
        let TorusScratch { pair, fft, .. } = scratch;
        let (n, half) = (self.n_phi, T::of(0.5));
        let block_len = self.n_rows() * ORDERS;
        let corrections = self.phi_correction.as_chunks::<ORDERS>().0;
        let rows = grid[layout.margin * layout.stride..].chunks(2 * layout.stride);
        for (first, rows) in (0..self.n_rows()).step_by(2).zip(rows) {
            let (one, other) = rows.split_at(layout.stride);
            // Beyond the last row of an odd number is one that was folded onto another.
            let values = one[layout.margin..].iter().zip(&other[layout.margin..]);
            for (z, (&re, &im)) in pair[..n].iter_mut().zip(values) {
                *z = Complex { re, im };
            }
            self.phi_forward.process_with_scratch(&mut pair[..n], fft);
            pair[n] = pair[0];
            // The transform of a + i b at m and n - m tells those of the real a and b apart.
            let last = first + 1 == self.n_rows();
            for (block, corrections) in corrections.iter().enumerate() {
                let m = block * ORDERS;
                let here = &pair[m..m + ORDERS];
                let there = &pair[n + 1 - m - ORDERS..=n - m];
                let mut a = [Complex::default(); ORDERS];
                let mut b = [Complex::default(); ORDERS];
                for i in 0..ORDERS {
                    let (here, there) = (here[i], there[ORDERS - 1 - i].conj());
                    let factor = corrections[i] * half;
                    let turned = here - there;
                    a[i] = (here + there) * factor;
                    b[i] = Complex { re: turned.im, im: -turned.re } * factor;
                }
                let place = &mut spectra[block * block_len + first * ORDERS..];
                place[..ORDERS].copy_from_slice(&a);
                if !last {
                    place[ORDERS..2 * ORDERS].copy_from_slice(&b);
                }
            }
        }
    }

    /// Adds what lies beyond the ends of a row to its other end, and rows beyond a pole to those that
    /// stand for the same theta, half a turn further.
    #[inline(always)]
    fn fold(&self, grid: &mut [T], layout: Layout) {
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        for row in grid.chunks_exact_mut(stride) {
            let (before, rest) = row.split_at_mut(margin);
            let (body, after) = rest.split_at_mut(n);
            add(&mut body[n - margin..], before);
            add(body, after);
        }
        self.for_mirrored_rows(layout, |beyond, within| {
            let (first, second) = grid.split_at_mut(beyond.max(within) * stride);
            let (first, second) = (&mut first[beyond.min(within) * stride..], second);
            let (from, to) = if beyond < within { (first, second) } else { (second, first) };
            let (left, right) = to[margin..][..n].split_at_mut(n / 2);
            add(left, &from[margin + n / 2..][..n / 2]);
            add(right, &from[margin..][..n / 2]);
        });
    }

    /// Calls back with each row of the grid beyond a pole, and the row at the same theta.
    #[inline(always)]
    fn for_mirrored_rows(&self, layout: Layout, mut call: impl FnMut(usize, usize)) {
        let (north, south) = (layout.margin, layout.margin + self.n_theta / 2);
        for i in 1..=layout.margin {
            call(north - i, north + i);
            call(south + i, south - i);
        }
    }

    /// The way back of [`Self::analyse_rows`]: its transpose, filling the whole grid.
    #[inline(always)]
    fn synthesise_rows(
        &self,
        spectra: &[Complex<T>],
        grid: &mut [T],
        layout: Layout,
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { pair, fft, .. } = scratch;
        let n = self.n_phi;
        let block_len = self.n_rows() * ORDERS;
        let corrections = self.phi_correction.as_chunks::<ORDERS>().0;
        let rows = grid[layout.margin * layout.stride..].chunks_mut(2 * layout.stride);
        for (first, rows) in (0..self.n_rows()).step_by(2).zip(rows) {
            pair.fill(Complex::default());
            let last = first + 1 == self.n_rows();
            for (block, corrections) in corrections.iter().enumerate() {
                let place = &spectra[block * block_len + first * ORDERS..];
                for i in 0..ORDERS {
                    let m = block * ORDERS + i;
                    let a = place[i] * corrections[i];
                    let b =
                        if last { a * T::default() } else { place[ORDERS + i] * corrections[i] };
                    pair[n - m] = a.conj() + Complex { re: b.im, im: b.re };
                    pair[m] = a + Complex { re: -b.im, im: b.re };
                    if m == 0 {
                        // Only the real part is part of a real function.
                        pair[0] = Complex { re: a.re, im: b.re };
                    }
                }
            }
            self.phi_inverse.process_with_scratch(&mut pair[..n], fft);
            let (one, other) = rows.split_at_mut(layout.stride);
            for (x, z) in one[layout.margin..].iter_mut().zip(&pair[..n]) {
                *x = z.re;
            }
            if !last {
                for (x, z) in other[layout.margin..].iter_mut().zip(&pair[..n]) {
                    *x = z.im;
                }
            }
        }
        self.unfold(grid, layout);
    }

    /// The way back of [`Self::fold`]: repeats rows beyond their ends and beyond the poles.
    #[inline(always)]
    fn unfold(&self, grid: &mut [T], layout: Layout) {
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        self.for_mirrored_rows(layout, |beyond, within| {
            let (from, to) = (within * stride + margin, beyond * stride + margin);
            grid.copy_within(from..from + n / 2, to + n / 2);
            grid.copy_within(from + n / 2..from + n, to);
        });
        for row in grid.chunks_exact_mut(stride) {
            row.copy_within(n..n + margin, 0);
            row.copy_within(margin..stride - n, margin + n);
        }
    }

    /// From spectra to ring terms for the orders from `first`, a multiple of `ORDERS`: order `first + i`
    /// on ring r at `i * n_ring_rows + r`.
    #[inline(always)]
    fn analyse_columns(
        &self,
        first: usize,
        spectra: &[Complex<T>],
        terms: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { columns, rings, fft, .. } = scratch;
        let (n, pole) = (self.n_theta, self.n_theta / 2);
        let block = spectra[self.block(first)].as_chunks::<ORDERS>().0;
        for (p, column) in columns.chunks_exact_mut(n).enumerate() {
            let (ahead, back) = column.split_at_mut(pole);
            let between = ahead[1..].iter_mut().zip(back[1..].iter_mut().rev());
            for (row, (here, mirrored)) in block[1..pole].iter().zip(between) {
                let (even, odd) = (row[2 * p], row[2 * p + 1]);
                *here = even + odd;
                *mirrored = even - odd;
            }
            // An odd column vanishes at the poles, an even one is its own mirror image.
            ahead[0] = block[0][2 * p] + block[0][2 * p];
            back[0] = block[pole][2 * p] + block[pole][2 * p];
        }
        self.theta_forward.process_with_scratch(columns, fft);
        // One 1/2 because the symmetrised column counts everything twice, one over the rings.
        let scale = T::of(0.5 / self.n_rings as f64);
        for (ring, column) in rings.chunks_exact_mut(self.n_rings).zip(columns.chunks_exact(n)) {
            self.transfer(column, ring, scale);
        }
        self.rings_inverse.process_with_scratch(rings, fft);
        let rows = self.n_ring_rows();
        let pairs = terms.chunks_exact_mut(2 * rows);
        for (pair, ring) in pairs.zip(rings.chunks_exact(self.n_rings)) {
            let (even, odd) = pair.split_at_mut(rows);
            let inner = 1..rows - 1;
            let values = ring[inner.clone()].iter().zip(ring[rows..].iter().rev());
            let terms = even[inner.clone()].iter_mut().zip(&mut odd[inner]);
            for ((even, odd), (here, mirrored)) in terms.zip(values) {
                // Rings between the poles stand for their mirror image on the torus too.
                *even = here + mirrored;
                *odd = here - mirrored;
            }
            (even[0], even[rows - 1]) = (ring[0], ring[rows - 1]);
            (odd[0], odd[rows - 1]) = (Complex::default(), Complex::default());
        }
    }

    /// Frequencies up to lmax in either direction, corrected for the window, from one length to another.
    #[inline(always)]
    fn transfer(&self, from: &[Complex<T>], to: &mut [Complex<T>], scale: T) {
        let last = self.lmax;
        let corrections = &self.theta_correction;
        for ((to, from), &correction) in to.iter_mut().zip(from).zip(corrections) {
            *to = *from * (correction * scale);
        }
        let tail = to.len() - last;
        to[last + 1..tail].fill(Complex::default());
        let from = &from[from.len() - last..];
        for ((to, from), &correction) in
            to[tail..].iter_mut().zip(from).zip(corrections[1..].iter().rev())
        {
            *to = *from * (correction * scale);
        }
    }

    /// The way back of [`Self::analyse_columns`]: its transpose, from ring values.
    #[inline(always)]
    fn synthesise_columns(
        &self,
        first: usize,
        values: &[Complex<T>],
        spectra: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { columns, rings, fft, .. } = scratch;
        let rows = self.n_ring_rows();
        for (pair, ring) in values.chunks_exact(2 * rows).zip(rings.chunks_exact_mut(self.n_rings))
        {
            let (even, odd) = pair.split_at(rows);
            let inner = 1..rows - 1;
            let (ahead, back) = ring.split_at_mut(rows);
            let values = ahead[inner.clone()].iter_mut().zip(back.iter_mut().rev());
            let terms = even[inner.clone()].iter().zip(&odd[inner]);
            for ((even, odd), (here, mirrored)) in terms.zip(values) {
                *here = even + odd;
                *mirrored = even - odd;
            }
            // A function of odd order vanishes at the poles.
            (ahead[0], ahead[rows - 1]) = (even[0], even[rows - 1]);
        }
        self.rings_forward.process_with_scratch(rings, fft);
        let n = self.n_theta;
        let scale = T::of(0.5 / self.n_rings as f64);
        for (ring, column) in rings.chunks_exact(self.n_rings).zip(columns.chunks_exact_mut(n)) {
            self.transfer(ring, column, scale);
        }
        self.theta_inverse.process_with_scratch(columns, fft);
        let pole = n / 2;
        let block = spectra[self.block(first)].as_chunks_mut::<ORDERS>().0;
        for (p, column) in columns.chunks_exact(n).enumerate() {
            let (ahead, back) = column.split_at(pole);
            let between = ahead[1..].iter().zip(back[1..].iter().rev());
            for (row, (here, mirrored)) in block[1..pole].iter_mut().zip(between) {
                row[2 * p] = here + mirrored;
                row[2 * p + 1] = here - mirrored;
            }
            for (row, value) in [(0, ahead[0]), (pole, back[0])] {
                (block[row][2 * p], block[row][2 * p + 1]) = (value + value, Complex::default());
            }
        }
    }
}

/// One of the four stages with its arguments, to be compiled for the instruction set at hand.
pub(crate) enum Stage<'a, T> {
    AnalyseRows { grid: &'a mut [T], layout: Layout, spectra: &'a mut [Complex<T>] },
    AnalyseColumns { first: usize, spectra: &'a [Complex<T>], terms: &'a mut [Complex<T>] },
    SynthesiseColumns { first: usize, values: &'a [Complex<T>], spectra: &'a mut [Complex<T>] },
    SynthesiseRows { spectra: &'a [Complex<T>], grid: &'a mut [T], layout: Layout },
}

struct Run<'a, T> {
    torus: &'a Torus<T>,
    stage: Stage<'a, T>,
    scratch: &'a mut TorusScratch<T>,
}

impl<T: Real> NullaryFnOnce for Run<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { torus, stage, scratch } = self;
        match stage {
            Stage::AnalyseRows { grid, layout, spectra } => {
                torus.analyse_rows(grid, layout, spectra, scratch);
            }
            Stage::AnalyseColumns { first, spectra, terms } => {
                torus.analyse_columns(first, spectra, terms, scratch);
            }
            Stage::SynthesiseColumns { first, values, spectra } => {
                torus.synthesise_columns(first, values, spectra, scratch);
            }
            Stage::SynthesiseRows { spectra, grid, layout } => {
                torus.synthesise_rows(spectra, grid, layout, scratch);
            }
        }
    }
}

#[inline(always)]
fn add<T: AddAssign + Copy>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += *from;
    }
}

/// `theta = pi r/R`, exact at the poles and on the equator's two sides alike.
fn ring_colatitude(r: usize, half: usize) -> Colatitude {
    let near = r.min(half - r);
    // From the nearer of pole and equator: the rounding of the angle is relative to it.
    let (sin, cos) = if 4 * near <= half {
        (PI * near as f64 / half as f64).sin_cos()
    } else {
        let (cos, sin) = (PI * (half - 2 * near) as f64 / (2 * half) as f64).sin_cos();
        (sin, cos)
    };
    let z = if 2 * r > half { -cos } else { cos };
    Colatitude::from_direction(DVec3::new(sin, 0.0, z))
}
