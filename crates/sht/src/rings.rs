use num_complex::Complex;
use pulp::Arch;
use sphvar_sh::{Alm, Colatitude, Error, LmIndex, Recurrence};

use crate::kernel::Column;
use crate::lanes::Lanes;

/// The Legendre part of a transform, `a_lm = sum_r lambda_lm(theta_r) f_m(r)`, from Fourier
/// coefficients `f_m` on rings r of constant colatitude.
///
/// For a quadrature over rings, `f_m(r)` is the ring's weight times its Fourier coefficient
/// `int f e^{-i m phi} dphi`.
///
/// Cost: about `R (lmax + 1)^2 / 2` steps of six vector instructions for R rings, at any
/// colatitudes; no tables.
#[derive(Clone, Debug)]
pub struct RingTransform {
    arch: Arch,
    index: LmIndex,
}

/// Scratch memory of [`RingTransform::adjoint_into`]; grows to the largest input it has seen.
#[derive(Clone, Debug, Default)]
pub struct RingWorkspace {
    lanes: Lanes,
    recurrence: Recurrence,
    sums: Vec<f64>,
    fourier: Vec<Complex<f64>>,
    column: Vec<Complex<f64>>,
}

impl RingTransform {
    /// The transform to degree `lmax`, inclusive. Builds no tables.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` is beyond what coefficients can be indexed for.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        Ok(Self { arch: Arch::new(), index: LmIndex::new(lmax)? })
    }

    /// The largest degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Replaces `out` by the coefficients of the rings at `colatitudes`. `fourier` is called once
    /// for each m from 0 to lmax, in this order, and writes `f_m` of every ring.
    ///
    /// # Panics
    ///
    /// If `out` is not of this transform's lmax.
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
    /// The recurrence is run once for several functions, so that four of them cost about half of
    /// what they cost one by one.
    ///
    /// # Panics
    ///
    /// If one of `outs` is not of this transform's lmax.
    pub fn adjoint_batch_into(
        &self,
        colatitudes: impl Iterator<Item = Colatitude>,
        mut fourier: impl FnMut(usize, &mut [Complex<f64>]),
        workspace: &mut RingWorkspace,
        outs: &mut [Alm],
    ) {
        for out in &*outs {
            assert_eq!(out.lmax(), self.lmax(), "coefficients of another lmax");
        }
        let RingWorkspace { lanes, recurrence, sums, fourier: values, column } = workspace;
        let n_rings = lanes.load(colatitudes);
        let n_functions = outs.len();
        values.clear();
        values.resize(n_rings * n_functions, Complex::ZERO);
        for m in 0..=self.lmax() {
            recurrence.fill(m, self.lmax());
            fourier(m, values);
            lanes.start_order(m, values, n_rings);
            self.arch.dispatch(Column { lanes, n_functions, recurrence, sums, out: column });
            let degrees = self.lmax() + 1 - m;
            for (out, values) in outs.iter_mut().zip(column.chunks_exact(degrees)) {
                out.column_mut(m).copy_from_slice(values);
            }
        }
    }
}
