use glam::DVec3;
use num_complex::Complex;
use pulp::Arch;
use sphvar_nufft::parts::{
    Cells, Design, Real, Spreading, Threads, magnitude_of, magnitude_of_complex, share,
};
use sphvar_sh::Alm;

use crate::RingTransform;
use crate::angles::{Angles, Directions};
use crate::legendre::FUNCTIONS;
use crate::rings::RingWorker;
use crate::torus::{Layout, ORDERS, ROWS, Stage, Torus, TorusScratch};

/// The fast transform with grids of type `T`.
#[derive(Clone)]
pub(crate) struct Engine<T> {
    arch: Arch,
    angles: Angles,
    spreading: Spreading<T>,
    torus: Torus<T>,
}

/// Workspace of [`Engine`].
#[derive(Debug, Default)]
pub(crate) struct Scratch<T> {
    cells: Cells<T>,
    /// The grid of one set, or the grids of all functions.
    grid: Vec<T>,
    /// Indexed by set or function, up to `FUNCTIONS`.
    spectra: Vec<Complex<T>>,
    /// One for each thread.
    workers: Vec<Worker<T>>,
    /// The divisors that scale the coefficients, one per function.
    sizes: Vec<f64>,
    values: Vec<f64>,
}

/// Workspace of a thread.
#[derive(Debug, Default)]
struct Worker<T> {
    torus: TorusScratch<T>,
    rings: RingWorker,
    /// For `ORDERS` orders, indexed by set or function, order, and ring.
    ring_values: Vec<Complex<T>>,
    /// The same for one order, by set or function, and ring.
    order_values: Vec<Complex<f64>>,
}

impl<T: Real> Engine<T> {
    pub(crate) fn new(lmax: usize, design: Design, arch: Arch) -> Self {
        let torus = Torus::new(lmax, design);
        let cells = [torus.n_theta(), torus.n_phi()];
        // The half grid, from the north to the south pole.
        let spreading = Spreading::new(cells, torus.n_rows(), design.window, design.epsilon);
        Self { arch, angles: Angles::new(), spreading, torus }
    }

    /// Returns the number of grid cells per turn of phi.
    pub(crate) fn n_phi(&self) -> usize {
        self.torus.n_phi()
    }

    fn layout(&self) -> Layout {
        Layout { stride: self.spreading.stride(), margin: self.spreading.margin() }
    }

    fn run(&self, stage: Stage<'_, T>, scratch: &mut TorusScratch<T>) {
        self.torus.run(self.arch, self.layout(), stage, scratch);
    }

    /// Returns groups of `ROWS` rows between the poles, and the row that each begins with.
    fn groups<'g>(
        &self,
        grid: &'g mut [T],
    ) -> impl Iterator<Item = (usize, &'g mut [T])> + use<'g, T> {
        let Layout { stride, margin } = self.layout();
        let rows = (0..self.torus.n_rows()).step_by(ROWS);
        rows.zip(grid[margin * stride..].chunks_mut(ROWS * stride))
    }

    /// Prepares workers for the orders of up to `FUNCTIONS` functions.
    fn load(&self, rings: &RingTransform, n_functions: usize, workers: &mut [Worker<T>]) {
        let n_values = self.torus.n_ring_rows() * n_functions;
        for worker in workers {
            worker.rings.load_torus(rings, &self.torus);
            worker.ring_values.resize(n_values * ORDERS, Complex::default());
            worker.order_values.resize(n_values, Complex::default());
        }
    }

    /// See [`FastTransform::adjoint_batch_into`](crate::FastTransform::adjoint_batch_into).
    pub(crate) fn adjoint(
        &self,
        rings: &RingTransform,
        sets: &[(&[DVec3], Option<&[f64]>)],
        threads: Threads,
        scratch: &mut Scratch<T>,
        outs: &mut [Alm],
    ) {
        threads.resize(&mut scratch.workers);
        for (sets, outs) in sets.chunks(FUNCTIONS).zip(outs.chunks_mut(FUNCTIONS)) {
            self.adjoint_group(rings, sets, threads, scratch, outs);
        }
    }

    /// Transforms up to `FUNCTIONS` sets.
    fn adjoint_group(
        &self,
        rings: &RingTransform,
        sets: &[(&[DVec3], Option<&[f64]>)],
        threads: Threads,
        scratch: &mut Scratch<T>,
        outs: &mut [Alm],
    ) {
        let Scratch { cells, grid, spectra, workers, .. } = scratch;
        let torus = &self.torus;
        spectra.resize(torus.spectra_len() * sets.len(), Complex::default());
        grid.resize(self.spreading.grid_len(), T::default());
        let mut sizes = [1.0; FUNCTIONS];
        for (((points, weights), size), spectra) in
            sets.iter().zip(&mut sizes).zip(spectra.chunks_exact_mut(torus.spectra_len()))
        {
            *size = weights.map_or(1.0, magnitude_of);
            let points = Directions { angles: &self.angles, points };
            self.spreading.locate(self.arch, &points, *weights, 1.0 / *size, threads, cells);
            self.spreading.spread(self.arch, cells, threads, grid);
            self.run(Stage::FoldPoles { grid }, &mut TorusScratch::default());
            let groups = self.groups(grid).zip(spectra.chunks_exact_mut(torus.group_len()));
            share(workers, groups, |worker, ((first, rows), spectra)| {
                self.run(Stage::AnalyseRows { first, rows, spectra }, &mut worker.torus);
            });
        }
        self.load(rings, sets.len(), workers);
        let mut columns: [&mut [Complex<f64>]; FUNCTIONS] = Default::default();
        for (columns, out) in columns.iter_mut().zip(&mut *outs) {
            assert_eq!(out.lmax(), rings.lmax(), "coefficients with a different lmax");
            *columns = out.values_mut();
        }
        // Coefficients of an order are contiguous and follow those of the order before.
        let n_coefficients = |m: usize| rings.index().column(m).len();
        let blocks = (0..=rings.lmax()).step_by(ORDERS).map(|first| {
            let orders = first..(first + ORDERS).min(rings.lmax() + 1);
            let len = orders.clone().map(n_coefficients).sum();
            (orders, split_off(&mut columns, len))
        });
        let n_rings = torus.n_ring_rows();
        share(workers, blocks, |worker, (orders, mut columns)| {
            let Worker { torus: torus_scratch, rings: ring_worker, ring_values, order_values } =
                worker;
            let sets = spectra.chunks_exact(torus.spectra_len());
            for (terms, spectra) in ring_values.chunks_exact_mut(n_rings * ORDERS).zip(sets) {
                let first = orders.start;
                self.run(Stage::AnalyseColumns { first, spectra, terms }, torus_scratch);
            }
            for (i, m) in orders.enumerate() {
                let by_set = ring_values.chunks_exact(n_rings * ORDERS);
                for (terms, values) in order_values.chunks_exact_mut(n_rings).zip(by_set) {
                    for (term, value) in terms.iter_mut().zip(&values[i * n_rings..]) {
                        *term = Complex::new(value.re.to_f64(), value.im.to_f64());
                    }
                }
                let mut outs = split_off(&mut columns, n_coefficients(m));
                let outs = &mut outs[..order_values.len() / n_rings];
                ring_worker.adjoint(rings, m, order_values, outs);
                for (out, &size) in outs.iter_mut().zip(&sizes) {
                    if size.to_bits() != 1f64.to_bits() {
                        for a in &mut **out {
                            *a *= size;
                        }
                    }
                }
            }
        });
    }

    /// See [`FastTransform::synthesis_batch_into`](crate::FastTransform::synthesis_batch_into).
    /// Leaves the values of all functions at each point, point by point, in `scratch`.
    pub(crate) fn synthesis(
        &self,
        rings: &RingTransform,
        alms: &[&Alm],
        points: &[DVec3],
        threads: Threads,
        scratch: &mut Scratch<T>,
    ) {
        threads.resize(&mut scratch.workers);
        let Scratch { cells, grid, spectra, workers, sizes, values } = scratch;
        sizes.clear();
        sizes.extend(alms.iter().map(|alm| magnitude_of_complex(alm.values())));
        let grid_len = self.spreading.grid_len();
        grid.resize(grid_len * alms.len(), T::default());
        let groups = alms.chunks(FUNCTIONS).zip(sizes.chunks(FUNCTIONS));
        for ((alms, sizes), grids) in groups.zip(grid.chunks_mut(grid_len * FUNCTIONS)) {
            self.synthesise_group(rings, alms, sizes, spectra, workers, grids);
        }
        values.resize(points.len() * alms.len(), 0.0);
        let points = Directions { angles: &self.angles, points };
        self.spreading.locate::<f64>(self.arch, &points, None, 1.0, threads, cells);
        self.spreading.interpolate(self.arch, cells, grid, sizes, threads, values);
    }

    /// Computes the grids of up to `FUNCTIONS` functions divided by their sizes.
    fn synthesise_group(
        &self,
        rings: &RingTransform,
        alms: &[&Alm],
        sizes: &[f64],
        spectra: &mut Vec<Complex<T>>,
        workers: &mut [Worker<T>],
        grids: &mut [T],
    ) {
        let torus = &self.torus;
        let n_rings = torus.n_ring_rows();
        self.load(rings, alms.len(), workers);
        spectra.resize(torus.spectra_len() * alms.len(), Complex::default());
        let mut functions: [&mut [Complex<T>]; FUNCTIONS] = Default::default();
        for (function, spectra) in
            functions.iter_mut().zip(spectra.chunks_exact_mut(torus.spectra_len()))
        {
            *function = spectra;
        }
        let blocks = (0..=rings.lmax()).step_by(ORDERS).map(|first| {
            let orders = first..(first + ORDERS).min(rings.lmax() + 1);
            (orders, split_off(&mut functions, torus.block_len()))
        });
        share(workers, blocks, |worker, (orders, spectra)| {
            let Worker { torus: torus_scratch, rings: ring_worker, ring_values, order_values } =
                worker;
            if orders.len() < ORDERS {
                ring_values.fill(Complex::default());
            }
            for (i, m) in orders.enumerate() {
                ring_worker.synthesis(rings, m, alms, order_values);
                let by_function = ring_values.chunks_exact_mut(n_rings * ORDERS);
                let columns = order_values.chunks_exact(n_rings).zip(sizes);
                for (values, (column, size)) in by_function.zip(columns) {
                    for (value, f) in values[i * n_rings..].iter_mut().zip(column) {
                        *value = Complex { re: T::of(f.re / size), im: T::of(f.im / size) };
                    }
                }
            }
            let by_function = ring_values.chunks_exact(n_rings * ORDERS);
            for (values, spectra) in by_function.zip(spectra) {
                self.run(Stage::SynthesiseColumns { values, spectra }, torus_scratch);
            }
        });
        let grids = grids.chunks_exact_mut(self.spreading.grid_len());
        for (grid, spectra) in grids.zip(spectra.chunks_exact(torus.spectra_len())) {
            share(workers, self.groups(grid), |worker, (first, rows)| {
                self.run(Stage::SynthesiseRows { first, spectra, rows }, &mut worker.torus);
            });
            self.run(Stage::UnfoldPoles { grid }, &mut TorusScratch::default());
        }
    }
}

/// Splits off the first `len` elements of several slices; slices that have fewer become empty.
fn split_off<'a, A, const N: usize>(slices: &mut [&'a mut [A]; N], len: usize) -> [&'a mut [A]; N] {
    slices.each_mut().map(|slice| {
        let (head, tail) = std::mem::take(slice).split_at_mut_checked(len).unwrap_or_default();
        *slice = tail;
        head
    })
}

impl<T> Scratch<T> {
    /// Returns the values of the last synthesis, indexed by point and function.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}
