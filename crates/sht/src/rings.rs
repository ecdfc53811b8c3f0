use num_complex::Complex;
use pulp::Arch;
use sphvar_nufft::parts::Real;
use sphvar_sh::{Alm, Colatitude, Error, LmIndex};

use crate::legendre::{Adjoint, Arithmetic, Columns, FUNCTIONS, Lanes, Order, Synthesis};
use crate::torus::Torus;

/// Legendre stage of a transform, between coefficients and Fourier coefficients `f_m` on rings r of
/// constant colatitude.
///
/// The adjoint is `a_lm = sum_r lambda_lm(theta_r) f_m(r)`, the synthesis
/// `f_m(r) = sum_l a_lm lambda_lm(theta_r)`. For a quadrature over rings, `f_m(r)` is the weight of
/// the ring times its Fourier coefficient `int f e^{-i m phi} dphi`.
///
/// # Performance
///
/// About `R (lmax + 1)^2 / 4` steps of seven vector operations for R rings at any colatitudes.
/// Rings that are reflections of each other at the equator count once. There are no tables.
#[derive(Clone, Debug)]
pub struct RingTransform {
    arch: Arch,
    index: LmIndex,
    arithmetic: Arithmetic,
}

/// Workspace of [`RingTransform`]; grows to the largest input so far.
#[derive(Clone, Debug, Default)]
pub struct RingWorkspace {
    worker: RingWorker,
    fourier: Vec<Complex<f64>>,
}

/// What a thread needs to process orders, in increasing order.
#[derive(Clone, Debug, Default)]
pub(crate) struct RingWorker {
    lanes: Lanes,
    /// The rings of the lanes, if they are those of a torus.
    torus: Option<TorusRings>,
    /// The number of orders that the lanes have passed.
    orders: usize,
    order: Order,
    columns: Columns,
}

/// The equidistant rings of the transform on the torus, and what else the lanes depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TorusRings {
    n_rings: usize,
    lmax: usize,
    arithmetic: Arithmetic,
}

impl RingWorker {
    /// Loads the rings at `colatitudes` for a transform.
    pub(crate) fn load(
        &mut self,
        transform: &RingTransform,
        colatitudes: impl Iterator<Item = Colatitude>,
    ) {
        self.lanes.load(colatitudes, transform.lmax(), transform.arithmetic);
        self.torus = None;
        self.orders = 0;
    }

    /// Loads the rings of a torus for a transform, which takes no time if the worker has the same
    /// rings already.
    pub(crate) fn load_torus<T: Real>(&mut self, transform: &RingTransform, torus: &Torus<T>) {
        let (n_rings, lmax) = (torus.n_ring_rows(), transform.lmax());
        let rings = TorusRings { n_rings, lmax, arithmetic: transform.arithmetic };
        if self.torus != Some(rings) {
            self.load(transform, torus.colatitudes());
            self.torus = Some(rings);
        }
        // Order 0 initializes the lanes.
        self.orders = 0;
    }

    /// Advances to order `m`, which must not be below earlier ones.
    fn advance(&mut self, transform: &RingTransform, m: usize) {
        for order in self.orders..=m {
            self.lanes.start_order(transform.arch, order);
        }
        self.orders = m + 1;
        self.order.fill(transform.arch, m, transform.lmax(), transform.arithmetic);
    }

    /// Replaces `outs`, the coefficients of order `m` of up to `FUNCTIONS` functions, by those of
    /// the ring values `f_m` of function b at `values[b * n_rings..]`.
    pub(crate) fn adjoint(
        &mut self,
        transform: &RingTransform,
        m: usize,
        values: &[Complex<f64>],
        outs: &mut [&mut [Complex<f64>]],
    ) {
        self.advance(transform, m);
        let Self { lanes, order, columns: scratch, .. } = self;
        Adjoint { lanes, order, m, values, scratch, outs }.run(transform.arch);
    }

    /// Replaces the ring values of order `m` by those of up to `FUNCTIONS` functions: the transpose
    /// of [`Self::adjoint`].
    pub(crate) fn synthesis(
        &mut self,
        transform: &RingTransform,
        m: usize,
        alms: &[&Alm],
        values: &mut [Complex<f64>],
    ) {
        self.advance(transform, m);
        let Self { lanes, order, columns: scratch, .. } = self;
        Synthesis { lanes, order, m, alms, scratch, values }.run(transform.arch);
    }
}

impl RingTransform {
    /// Returns the transform to degree `lmax`, inclusive. Builds no tables.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` exceeds the limit of the coefficient index.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        Self::with_arch(lmax, Arch::new(), Arithmetic::default())
    }

    /// Returns the transform for a given instruction set and a given arithmetic.
    pub(crate) fn with_arch(
        lmax: usize,
        arch: Arch,
        arithmetic: Arithmetic,
    ) -> Result<Self, Error> {
        Ok(Self { arch, index: LmIndex::new(lmax)?, arithmetic })
    }

    /// Returns the layout of the coefficients.
    pub(crate) fn index(&self) -> LmIndex {
        self.index
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Replaces `out` by the coefficients of the rings at `colatitudes`. `fourier` is called once
    /// for each m from 0 to lmax, in this order, and writes `f_m` for every ring.
    ///
    /// # Panics
    ///
    /// Panics if the lmax of `out` differs from that of the transform.
    pub fn adjoint_into(
        &self,
        colatitudes: impl Iterator<Item = Colatitude>,
        fourier: impl FnMut(usize, &mut [Complex<f64>]),
        workspace: &mut RingWorkspace,
        out: &mut Alm,
    ) {
        self.adjoint_batch_into(colatitudes, fourier, workspace, std::slice::from_mut(out));
    }

    /// Replaces each of `outs` by the coefficients of one function on the same rings. `fourier`
    /// writes `f_m` of function b on ring r at `b * n_rings + r`.
    ///
    /// Results are bit-identical whether functions are transformed singly or in a batch.
    ///
    /// # Panics
    ///
    /// Panics if the lmax of one of `outs` differs from that of the transform.
    ///
    /// # Performance
    ///
    /// Up to four functions share one pass of the recurrence: four cost little more than half of
    /// four single transforms.
    pub fn adjoint_batch_into(
        &self,
        colatitudes: impl Iterator<Item = Colatitude>,
        mut fourier: impl FnMut(usize, &mut [Complex<f64>]),
        workspace: &mut RingWorkspace,
        outs: &mut [Alm],
    ) {
        for out in &*outs {
            assert_eq!(out.lmax(), self.lmax(), "coefficients with a different lmax");
        }
        let RingWorkspace { worker, fourier: values } = workspace;
        worker.load(self, colatitudes);
        let n_rings = worker.lanes.n_rings();
        values.clear();
        values.resize(n_rings * outs.len(), Complex::ZERO);
        for m in 0..=self.lmax() {
            fourier(m, values);
            worker.advance(self, m);
            for (group, outs) in outs.chunks_mut(FUNCTIONS).enumerate() {
                let first = group * FUNCTIONS * n_rings;
                let values = &values[first..first + outs.len() * n_rings];
                let n_functions = outs.len();
                let mut columns: [&mut [Complex<f64>]; FUNCTIONS] = Default::default();
                for (column, out) in columns.iter_mut().zip(outs) {
                    *column = out.column_mut(m);
                }
                let outs = &mut columns[..n_functions];
                let RingWorker { lanes, order, columns: scratch, .. } = &mut *worker;
                Adjoint { lanes, order, m, values, scratch, outs }.run(self.arch);
            }
        }
    }

    /// Calls `emit` with the coefficients of degrees m to lmax of one function for each order m up to
    /// `max_order`, in this order, without those of all other orders in memory. `fourier` is called
    /// for each m and writes `f_m` for every ring; orders for which it returns `false` are left out.
    ///
    /// Results are bit-identical to those of [`adjoint_into`](Self::adjoint_into).
    pub fn adjoint_by_order(
        &self,
        colatitudes: impl Iterator<Item = Colatitude>,
        max_order: usize,
        mut fourier: impl FnMut(usize, &mut [Complex<f64>]) -> bool,
        workspace: &mut RingWorkspace,
        mut emit: impl FnMut(usize, &[Complex<f64>]),
    ) {
        let RingWorkspace { worker, fourier: values } = workspace;
        worker.load(self, colatitudes);
        values.clear();
        values.resize(worker.lanes.n_rings(), Complex::ZERO);
        let mut column = vec![Complex::ZERO; self.lmax() + 1];
        for m in 0..=max_order.min(self.lmax()) {
            if fourier(m, values) {
                let column = &mut column[m..];
                worker.adjoint(self, m, values, &mut [&mut *column]);
                emit(m, column);
            }
        }
    }

    /// Calls `emit` for each m from 0 to lmax, in this order, with `f_m` of each of `alms` on the
    /// rings at `colatitudes`: function b on ring r at `b * n_rings + r`.
    ///
    /// # Panics
    ///
    /// Panics if the lmax of one of `alms` differs from that of the transform.
    pub fn synthesis_batch_into(
        &self,
        colatitudes: impl Iterator<Item = Colatitude>,
        alms: &[&Alm],
        mut emit: impl FnMut(usize, &[Complex<f64>]),
        workspace: &mut RingWorkspace,
    ) {
        for alm in alms {
            assert_eq!(alm.lmax(), self.lmax(), "coefficients with a different lmax");
        }
        let RingWorkspace { worker, fourier: values } = workspace;
        worker.load(self, colatitudes);
        let n_rings = worker.lanes.n_rings();
        values.clear();
        values.resize(n_rings * alms.len(), Complex::ZERO);
        for m in 0..=self.lmax() {
            worker.advance(self, m);
            for (group, alms) in alms.chunks(FUNCTIONS).enumerate() {
                let first = group * FUNCTIONS * n_rings;
                let values = &mut values[first..first + alms.len() * n_rings];
                let RingWorker { lanes, order, columns: scratch, .. } = &mut *worker;
                Synthesis { lanes, order, m, alms, scratch, values }.run(self.arch);
            }
            emit(m, values);
        }
    }
}
