use glam::DVec3;
use num_complex::Complex;
use pulp::Arch;
use sphvar_nufft::parts::{Cells, Design, Real, Spreading, magnitude};
use sphvar_sh::Alm;

use crate::angles::{Angles, Directions};
use crate::torus::{Layout, ORDERS, Stage, Torus, TorusScratch};
use crate::{RingTransform, RingWorkspace};

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
    /// Indexed by set or function.
    spectra: Vec<Complex<T>>,
    /// For `ORDERS` orders, indexed by set or function, order, and ring.
    ring_values: Vec<Complex<T>>,
    torus: TorusScratch<T>,
    /// The divisors that scale the coefficients, one per function.
    sizes: Vec<f64>,
    values: Vec<f64>,
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

    /// See [`FastTransform::adjoint_batch_into`](crate::FastTransform::adjoint_batch_into).
    pub(crate) fn adjoint(
        &self,
        rings: &RingTransform,
        sets: &[(&[DVec3], Option<&[f64]>)],
        ring_workspace: &mut RingWorkspace,
        scratch: &mut Scratch<T>,
        outs: &mut [Alm],
    ) {
        let Scratch { cells, grid, spectra, ring_values, torus: torus_scratch, .. } = scratch;
        let torus = &self.torus;
        spectra.resize(torus.spectra_len() * sets.len(), Complex::default());
        for ((points, weights), spectra) in
            sets.iter().zip(spectra.chunks_exact_mut(torus.spectra_len()))
        {
            let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
            let points = Directions { angles: &self.angles, points };
            self.spreading.locate(self.arch, &points, *weights, 1.0 / size, cells);
            grid.clear();
            grid.resize(self.spreading.grid_len(), T::default());
            self.spreading.spread(self.arch, cells, grid);
            let stage = Stage::AnalyseRows { grid, layout: self.layout(), spectra };
            torus.run(self.arch, stage, torus_scratch);
        }
        let n_rings = torus.n_ring_rows();
        ring_values.resize(n_rings * ORDERS * sets.len(), Complex::default());
        let fourier = |m: usize, terms: &mut [Complex<f64>]| {
            let by_set = ring_values.chunks_exact_mut(n_rings * ORDERS);
            if m.is_multiple_of(ORDERS) {
                for (values, spectra) in by_set.zip(spectra.chunks_exact(torus.spectra_len())) {
                    let stage = Stage::AnalyseColumns { first: m, spectra, terms: values };
                    torus.run(self.arch, stage, torus_scratch);
                }
            }
            let by_set = ring_values.chunks_exact(n_rings * ORDERS);
            for (terms, values) in terms.chunks_exact_mut(n_rings).zip(by_set) {
                for (term, value) in terms.iter_mut().zip(&values[m % ORDERS * n_rings..]) {
                    *term = Complex::new(value.re.to_f64(), value.im.to_f64());
                }
            }
        };
        rings.adjoint_batch_into(torus.colatitudes(), fourier, ring_workspace, outs);
        for ((_, weights), out) in sets.iter().zip(outs) {
            if let Some(weights) = weights {
                let size = magnitude(weights.iter().copied());
                for a in out.values_mut() {
                    *a *= size;
                }
            }
        }
    }

    /// See [`FastTransform::synthesis_batch_into`](crate::FastTransform::synthesis_batch_into).
    /// Leaves the values of all functions at each point, point by point, in `scratch`.
    pub(crate) fn synthesis(
        &self,
        rings: &RingTransform,
        alms: &[&Alm],
        points: &[DVec3],
        ring_workspace: &mut RingWorkspace,
        scratch: &mut Scratch<T>,
    ) {
        let Scratch { cells, grid, spectra, ring_values, torus: torus_scratch, sizes, values } =
            scratch;
        sizes.clear();
        sizes.extend(
            alms.iter().map(|alm| magnitude(alm.values().iter().flat_map(|a| [a.re, a.im]))),
        );
        let torus = &self.torus;
        spectra.resize(torus.spectra_len() * alms.len(), Complex::default());
        let n_rings = torus.n_ring_rows();
        ring_values.resize(n_rings * ORDERS * alms.len(), Complex::default());
        let emit = |m: usize, columns: &[Complex<f64>]| {
            let by_function = ring_values.chunks_exact_mut(n_rings * ORDERS);
            let columns = columns.chunks_exact(n_rings).zip(&*sizes);
            for (values, (column, size)) in by_function.zip(columns) {
                if m.is_multiple_of(ORDERS) {
                    values.fill(Complex::default());
                }
                for (value, f) in values[m % ORDERS * n_rings..].iter_mut().zip(column) {
                    *value = Complex { re: T::of(f.re / size), im: T::of(f.im / size) };
                }
            }
            if m % ORDERS == ORDERS - 1 || m == rings.lmax() {
                let by_function = ring_values.chunks_exact(n_rings * ORDERS);
                for (values, spectra) in
                    by_function.zip(spectra.chunks_exact_mut(torus.spectra_len()))
                {
                    let first = m / ORDERS * ORDERS;
                    let stage = Stage::SynthesiseColumns { first, values, spectra };
                    torus.run(self.arch, stage, torus_scratch);
                }
            }
        };
        rings.synthesis_batch_into(torus.colatitudes(), alms, emit, ring_workspace);
        let grid_len = self.spreading.grid_len();
        grid.resize(grid_len * alms.len(), T::default());
        let grids = grid.chunks_exact_mut(grid_len);
        for (grid, spectra) in grids.zip(spectra.chunks_exact(torus.spectra_len())) {
            let stage = Stage::SynthesiseRows { spectra, grid, layout: self.layout() };
            torus.run(self.arch, stage, torus_scratch);
        }
        values.resize(points.len() * alms.len(), 0.0);
        let points = Directions { angles: &self.angles, points };
        self.spreading.locate::<f64>(self.arch, &points, None, 1.0, cells);
        self.spreading.interpolate(self.arch, cells, grid, sizes, values);
    }
}

impl<T> Scratch<T> {
    /// Returns the values of the last synthesis, indexed by point and function.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}
