use std::f64::consts::PI;
use std::ops::AddAssign;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};
use sphvar_nufft::parts::{Design, Fft, FftDirection, Real, good_size};
use sphvar_sh::Colatitude;

/// Number of orders whose columns are transformed together, so that they share cache lines.
pub(crate) const ORDERS: usize = 8;

/// Number of rows of the grid whose spectra are stored together, an even number.
pub(crate) const ROWS: usize = 16;

/// Fourier transforms between a grid and the rings of the Legendre stage, in both directions.
///
/// The sphere covers the torus twice, theta in [0, 2 pi), where a function of degree L is a
/// trigonometric polynomial: its column of order m is even about the poles for even m and odd for
/// odd m. Two rows of the grid, and two columns of different parity, share one complex transform.
///
/// The grid holds the function convolved with the window. *Spectra* are the Fourier coefficients in
/// phi of every row from pole to pole, in blocks of `ORDERS` orders. Those of the adjoint are
/// indexed by group of `ROWS` rows, block, row within the group, and order within the block; those
/// of the synthesis by block, row, and order. Stages that write them thus write contiguous memory,
/// which threads can divide.
#[derive(Clone)]
pub(crate) struct Torus<T> {
    lmax: usize,
    n_theta: usize,
    n_phi: usize,
    /// The number of rings on the whole torus, an even number 2R > 2 lmax; ring r is at
    /// `theta = pi r/R`.
    n_rings: usize,
    /// The reciprocal of the window's transform at each m, padded with zeros to a multiple of
    /// `ORDERS`, and at each k >= 0 (it is even in k).
    phi_correction: Box<[T]>,
    theta_correction: Box<[T]>,
    phi_forward: Arc<dyn Fft<T>>,
    phi_inverse: Arc<dyn Fft<T>>,
    theta_forward: Arc<dyn Fft<T>>,
    theta_inverse: Arc<dyn Fft<T>>,
    rings_forward: Arc<dyn Fft<T>>,
    rings_inverse: Arc<dyn Fft<T>>,
}

/// Workspace of [`Torus`].
#[derive(Debug, Default)]
pub(crate) struct TorusScratch<T> {
    pair: Vec<Complex<T>>,
    columns: Vec<Complex<T>>,
    rings: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

/// Memory layout of a grid: rows start at `margin` rows beyond the north pole, columns at `margin`
/// columns before phi = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub(crate) stride: usize,
    pub(crate) margin: usize,
}

impl<T: Real> Torus<T> {
    pub(crate) fn new(lmax: usize, design: Design) -> Self {
        let n = design.cells(lmax);
        // Each ring also has a cost in the Legendre stage.
        let n_rings = good_size((2 * lmax + 2) as f64, 1.03);
        let mut correction: Vec<T> =
            design.window.transform(n, lmax).into_iter().map(|t| T::of(1.0 / t)).collect();
        let theta_correction = correction.clone().into();
        correction.resize((lmax + 1).next_multiple_of(ORDERS), T::default());
        let (forward, inverse) = (FftDirection::Forward, FftDirection::Inverse);
        let (grid_forward, grid_inverse) =
            (T::fourier_plan(n, forward), T::fourier_plan(n, inverse));
        Self {
            lmax,
            n_theta: n,
            n_phi: n,
            n_rings,
            phi_correction: correction.into(),
            theta_correction,
            phi_forward: Arc::clone(&grid_forward),
            phi_inverse: Arc::clone(&grid_inverse),
            theta_forward: grid_forward,
            theta_inverse: grid_inverse,
            rings_forward: T::fourier_plan(n_rings, forward),
            rings_inverse: T::fourier_plan(n_rings, inverse),
        }
    }

    pub(crate) fn n_theta(&self) -> usize {
        self.n_theta
    }

    pub(crate) fn n_phi(&self) -> usize {
        self.n_phi
    }

    /// Returns the number of rings from pole to pole, both included.
    pub(crate) fn n_ring_rows(&self) -> usize {
        self.n_rings / 2 + 1
    }

    pub(crate) fn colatitudes(&self) -> impl Iterator<Item = Colatitude> + use<T> {
        let half = self.n_rings / 2;
        (0..=half).map(move |r| ring_colatitude(r, half))
    }

    /// Returns the number of grid rows from pole to pole, both included.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_theta / 2 + 1
    }

    /// Returns the length of the spectra of a group of `ROWS` rows, in the adjoint.
    pub(crate) fn group_len(&self) -> usize {
        ROWS * self.phi_correction.len()
    }

    /// Returns the length of the spectra of one block of orders, in the synthesis.
    pub(crate) fn block_len(&self) -> usize {
        self.n_rows() * ORDERS
    }

    /// Returns the length of the spectra of one set or function.
    pub(crate) fn spectra_len(&self) -> usize {
        self.n_rows().next_multiple_of(ROWS) * self.phi_correction.len()
    }

    /// Runs one stage.
    pub(crate) fn run(
        &self,
        arch: Arch,
        layout: Layout,
        stage: Stage<'_, T>,
        scratch: &mut TorusScratch<T>,
    ) {
        arch.dispatch(Run { torus: self, layout, stage, scratch });
    }

    fn prepare(&self, scratch: &mut TorusScratch<T>) {
        let ffts = [&self.phi_forward, &self.phi_inverse, &self.theta_forward, &self.theta_inverse];
        let ffts = ffts.into_iter().chain([&self.rings_forward, &self.rings_inverse]);
        let needed = ffts.map(|fft| fft.get_inplace_scratch_len()).max().unwrap_or(0);
        scratch.fft.resize(needed.max(scratch.fft.len()), Complex::default());
        scratch.pair.resize(self.n_phi + 1, Complex::default());
        scratch.columns.resize(self.n_theta * ORDERS / 2, Complex::default());
        scratch.rings.resize(self.n_rings, Complex::default());
    }

    /// Computes the spectra of a group of rows of a grid that points were spread on, from row
    /// `first` on, a multiple of `ROWS`. Overwrites the rows, which begin at their margins.
    #[inline(always)]
    fn analyse_rows(
        &self,
        first: usize,
        rows: &mut [T],
        layout: Layout,
        spectra: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { pair, fft, .. } = scratch;
        let (n, half) = (self.n_phi, T::of(0.5));
        let Layout { stride, margin } = layout;
        let corrections = self.phi_correction.as_chunks::<ORDERS>().0;
        let n_rows = ROWS.min(self.n_rows() - first);
        for (i, rows) in (0..n_rows).step_by(2).zip(rows.chunks_mut(2 * stride)) {
            for (i, row) in (i..n_rows).zip(rows.chunks_exact_mut(stride)) {
                if !self.is_near_pole(first + i, layout) {
                    self.fold_row(row, layout);
                }
            }
            let (one, other) = rows.split_at(stride);
            // For an odd number of rows, the row after the last was already folded onto another.
            let is_last = i + 1 == n_rows;
            let values = one[margin..].iter().zip(&other[margin..]);
            for (z, (&re, &im)) in pair[..n].iter_mut().zip(values) {
                *z = Complex { re, im };
            }
            self.phi_forward.process_with_scratch(&mut pair[..n], fft);
            pair[n] = pair[0];
            // The transform of a + i b at m and n - m separates into those of the real a and b.
            for (block, corrections) in corrections.iter().enumerate() {
                let m = block * ORDERS;
                let here = &pair[m..m + ORDERS];
                let there = &pair[n + 1 - m - ORDERS..=n - m];
                let mut a = [Complex::default(); ORDERS];
                let mut b = [Complex::default(); ORDERS];
                for i in 0..ORDERS {
                    let (here, there) = (here[i], there[ORDERS - 1 - i].conj());
                    let factor = corrections[i] * half;
                    let difference = here - there;
                    a[i] = (here + there) * factor;
                    b[i] = Complex { re: difference.im, im: -difference.re } * factor;
                }
                let place = &mut spectra[(block * ROWS + i) * ORDERS..][..2 * ORDERS];
                place[..ORDERS].copy_from_slice(&a);
                if !is_last {
                    place[ORDERS..].copy_from_slice(&b);
                }
            }
        }
    }

    /// Adds values beyond the ends of a row to its opposite end.
    #[inline(always)]
    fn fold_row(&self, row: &mut [T], layout: Layout) {
        let (before, rest) = row.split_at_mut(layout.margin);
        let (body, after) = rest.split_at_mut(self.n_phi);
        add(&mut body[self.n_phi - layout.margin..], before);
        add(body, after);
    }

    /// Returns whether [`Self::fold_poles`] folds a row.
    #[inline(always)]
    fn is_near_pole(&self, row: usize, layout: Layout) -> bool {
        row <= layout.margin || row + layout.margin >= self.n_theta / 2
    }

    /// Folds the rows near the poles, and adds rows beyond a pole to the rows of the same theta,
    /// shifted by half a turn.
    #[inline(always)]
    fn fold_poles(&self, grid: &mut [T], layout: Layout) {
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        for (row, values) in grid.chunks_exact_mut(stride).enumerate() {
            if row.checked_sub(margin).is_none_or(|row| self.is_near_pole(row, layout)) {
                self.fold_row(values, layout);
            }
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

    /// Calls `call` with each row of the grid beyond a pole and the row at the same theta.
    #[inline(always)]
    fn for_mirrored_rows(&self, layout: Layout, mut call: impl FnMut(usize, usize)) {
        let (north, south) = (layout.margin, layout.margin + self.n_theta / 2);
        for i in 1..=layout.margin {
            call(north - i, north + i);
            call(south + i, south - i);
        }
    }

    /// Fills rows of a grid from row `first` on, up to `ROWS`: the transpose of
    /// [`Self::analyse_rows`].
    #[inline(always)]
    fn synthesise_rows(
        &self,
        first: usize,
        spectra: &[Complex<T>],
        rows: &mut [T],
        layout: Layout,
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { pair, fft, .. } = scratch;
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        let corrections = self.phi_correction.as_chunks::<ORDERS>().0;
        let end = self.n_rows().min(first + ROWS);
        for (row, rows) in (first..end).step_by(2).zip(rows.chunks_mut(2 * stride)) {
            pair.fill(Complex::default());
            let is_last = row + 1 == end;
            let blocks = corrections.iter().zip(spectra.chunks_exact(self.block_len()));
            for (block, (corrections, spectra)) in blocks.enumerate() {
                let place = &spectra[row * ORDERS..];
                for i in 0..ORDERS {
                    let m = block * ORDERS + i;
                    let a = place[i] * corrections[i];
                    let b =
                        if is_last { a * T::default() } else { place[ORDERS + i] * corrections[i] };
                    pair[n - m] = a.conj() + Complex { re: b.im, im: b.re };
                    pair[m] = a + Complex { re: -b.im, im: b.re };
                    if m == 0 {
                        // A real function has a real component of order 0.
                        pair[0] = Complex { re: a.re, im: b.re };
                    }
                }
            }
            self.phi_inverse.process_with_scratch(&mut pair[..n], fft);
            let (one, other) = rows.split_at_mut(stride);
            for (x, z) in one[margin..].iter_mut().zip(&pair[..n]) {
                *x = z.re;
            }
            self.unfold_row(one, layout);
            if !is_last {
                for (x, z) in other[margin..].iter_mut().zip(&pair[..n]) {
                    *x = z.im;
                }
                self.unfold_row(&mut other[..stride], layout);
            }
        }
    }

    /// Extends a row periodically: the transpose of [`Self::fold_row`].
    #[inline(always)]
    fn unfold_row(&self, row: &mut [T], layout: Layout) {
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        row.copy_within(n..n + margin, 0);
        row.copy_within(margin..stride - n, margin + n);
    }

    /// Extends the rows of a grid across the poles: the transpose of [`Self::fold_poles`].
    #[inline(always)]
    fn unfold_poles(&self, grid: &mut [T], layout: Layout) {
        let (n, Layout { stride, margin }) = (self.n_phi, layout);
        self.for_mirrored_rows(layout, |beyond, within| {
            let (from, to) = (within * stride + margin, beyond * stride + margin);
            grid.copy_within(from..from + n / 2, to + n / 2);
            grid.copy_within(from + n / 2..from + n, to);
            self.unfold_row(&mut grid[beyond * stride..][..stride], layout);
        });
    }

    /// Computes ring terms from the spectra of a block of orders, in groups of rows: order i of the
    /// block on ring r at `i * n_ring_rows + r`.
    #[inline(always)]
    fn analyse_columns<'s>(
        &self,
        groups: impl Iterator<Item = &'s [[Complex<T>; ORDERS]; ROWS]>,
        terms: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { columns, rings, fft, .. } = scratch;
        let (n, pole) = (self.n_theta, self.n_theta / 2);
        for (row, group) in (0..=pole).step_by(ROWS).zip(groups) {
            self.gather_columns(row, group, columns);
        }
        // A factor 1/2 since the symmetrized column contains everything twice, and 1/n_rings.
        let scale = T::of(0.5 / self.n_rings as f64);
        let rows = self.n_ring_rows();
        let pairs = terms.chunks_exact_mut(2 * rows);
        // One column after the other, which the L1 cache can hold.
        for (pair, column) in pairs.zip(columns.chunks_exact_mut(n)) {
            self.theta_forward.process_with_scratch(column, fft);
            self.transfer(column, rings, scale);
            self.rings_inverse.process_with_scratch(rings, fft);
            let ring = &*rings;
            let (even, odd) = pair.split_at_mut(rows);
            let inner = 1..rows - 1;
            let values = ring[inner.clone()].iter().zip(ring[rows..].iter().rev());
            let terms = even[inner.clone()].iter_mut().zip(&mut odd[inner]);
            for ((even, odd), (here, mirrored)) in terms.zip(values) {
                // Rings between the poles also represent their reflection on the torus.
                *even = here + mirrored;
                *odd = here - mirrored;
            }
            (even[0], even[rows - 1]) = (ring[0], ring[rows - 1]);
            (odd[0], odd[rows - 1]) = (Complex::default(), Complex::default());
        }
    }

    /// Writes the rows of a group of spectra, from row `first` on, and their reflections to the
    /// columns of pairs of orders.
    #[inline(always)]
    fn gather_columns(
        &self,
        first: usize,
        group: &[[Complex<T>; ORDERS]; ROWS],
        columns: &mut [Complex<T>],
    ) {
        let (n, pole) = (self.n_theta, self.n_theta / 2);
        // Rows between the poles.
        let (start, end) = (first.max(1), pole.min(first + ROWS));
        for (row, values) in (first..end).zip(group).skip(start - first) {
            for (p, column) in columns.chunks_exact_mut(n).enumerate() {
                let (even, odd) = (values[2 * p], values[2 * p + 1]);
                column[row] = even + odd;
                column[n - row] = even - odd;
            }
        }
        for row in [0, pole] {
            if let Some(values) = row.checked_sub(first).and_then(|i| group.get(i)) {
                // An odd column vanishes at the poles; an even one is its own reflection.
                for (p, column) in columns.chunks_exact_mut(n).enumerate() {
                    column[row] = values[2 * p] + values[2 * p];
                }
            }
        }
    }

    /// Copies frequencies up to lmax of both signs, corrected for the window, between transforms of
    /// different lengths.
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

    /// Computes the spectra of a block of orders from ring values: the transpose of
    /// [`Self::analyse_columns`].
    #[inline(always)]
    fn synthesise_columns(
        &self,
        values: &[Complex<T>],
        spectra: &mut [Complex<T>],
        scratch: &mut TorusScratch<T>,
    ) {
        self.prepare(scratch);
        let TorusScratch { columns, rings, fft, .. } = scratch;
        let rows = self.n_ring_rows();
        let (n, scale) = (self.n_theta, T::of(0.5 / self.n_rings as f64));
        for (pair, column) in values.chunks_exact(2 * rows).zip(columns.chunks_exact_mut(n)) {
            let (even, odd) = pair.split_at(rows);
            let inner = 1..rows - 1;
            let (ahead, back) = rings.split_at_mut(rows);
            let values = ahead[inner.clone()].iter_mut().zip(back.iter_mut().rev());
            let terms = even[inner.clone()].iter().zip(&odd[inner]);
            for ((even, odd), (here, mirrored)) in terms.zip(values) {
                *here = even + odd;
                *mirrored = even - odd;
            }
            // A function of odd order vanishes at the poles.
            (ahead[0], ahead[rows - 1]) = (even[0], even[rows - 1]);
            self.rings_forward.process_with_scratch(rings, fft);
            self.transfer(rings, column, scale);
        }
        self.theta_inverse.process_with_scratch(columns, fft);
        let pole = n / 2;
        let block = spectra.as_chunks_mut::<ORDERS>().0;
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

/// One of the stages with its arguments, compiled for the selected instruction set.
pub(crate) enum Stage<'a, T> {
    FoldPoles {
        grid: &'a mut [T],
    },
    AnalyseRows {
        first: usize,
        rows: &'a mut [T],
        spectra: &'a mut [Complex<T>],
    },
    /// For the orders from `first`, a multiple of `ORDERS`.
    AnalyseColumns {
        first: usize,
        spectra: &'a [Complex<T>],
        terms: &'a mut [Complex<T>],
    },
    /// For spectra of one block of orders only, padded to whole groups of rows.
    AnalyseBlock {
        spectra: &'a [[Complex<T>; ORDERS]],
        terms: &'a mut [Complex<T>],
    },
    SynthesiseColumns {
        values: &'a [Complex<T>],
        spectra: &'a mut [Complex<T>],
    },
    SynthesiseRows {
        first: usize,
        spectra: &'a [Complex<T>],
        rows: &'a mut [T],
    },
    UnfoldPoles {
        grid: &'a mut [T],
    },
}

struct Run<'a, T> {
    torus: &'a Torus<T>,
    layout: Layout,
    stage: Stage<'a, T>,
    scratch: &'a mut TorusScratch<T>,
}

impl<T: Real> NullaryFnOnce for Run<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { torus, layout, stage, scratch } = self;
        match stage {
            Stage::FoldPoles { grid } => torus.fold_poles(grid, layout),
            Stage::AnalyseRows { first, rows, spectra } => {
                torus.analyse_rows(first, rows, layout, spectra, scratch);
            }
            Stage::AnalyseColumns { first, spectra, terms } => {
                let groups = spectra.chunks_exact(torus.group_len()).map(|group| {
                    let blocks = group.as_chunks::<ORDERS>().0.as_chunks::<ROWS>().0;
                    &blocks[first / ORDERS]
                });
                torus.analyse_columns(groups, terms, scratch);
            }
            Stage::AnalyseBlock { spectra, terms } => {
                let groups = spectra.as_chunks::<ROWS>().0.iter();
                torus.analyse_columns(groups, terms, scratch);
            }
            Stage::SynthesiseColumns { values, spectra } => {
                torus.synthesise_columns(values, spectra, scratch);
            }
            Stage::SynthesiseRows { first, spectra, rows } => {
                torus.synthesise_rows(first, spectra, rows, layout, scratch);
            }
            Stage::UnfoldPoles { grid } => torus.unfold_poles(grid, layout),
        }
    }
}

#[inline(always)]
fn add<T: AddAssign + Copy>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += *from;
    }
}

/// Returns `theta = pi r/R`, exact at the poles and symmetric about the equator.
fn ring_colatitude(r: usize, half: usize) -> Colatitude {
    let near = r.min(half - r);
    // The angle is measured from the nearer of pole and equator, so that its rounding is relative.
    let (sin, cos) = if 4 * near <= half {
        (PI * near as f64 / half as f64).sin_cos()
    } else {
        let (cos, sin) = (PI * (half - 2 * near) as f64 / (2 * half) as f64).sin_cos();
        (sin, cos)
    };
    let z = if 2 * r > half { -cos } else { cos };
    Colatitude::from_direction(DVec3::new(sin, 0.0, z))
}
