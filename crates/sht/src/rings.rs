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
    halves: [Half; 2],
    recurrence: Recurrence,
    sums: Vec<f64>,
    fourier: Vec<Complex<f64>>,
}

/// The rings of one hemisphere and the coefficients of one order that come from them.
#[derive(Clone, Debug, Default)]
struct Half {
    lanes: Lanes,
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
        mut fourier: impl FnMut(usize, &mut [Complex<f64>]),
        workspace: &mut RingWorkspace,
        out: &mut Alm,
    ) {
        assert_eq!(out.lmax(), self.lmax(), "coefficients of another lmax");
        let RingWorkspace { halves, recurrence, sums, fourier: values } = workspace;
        // Southern rings are evaluated at their mirror image in the equator, where lambda_lm only
        // changes sign with the parity of l + m: one sign at the end, none inside.
        for half in &mut *halves {
            half.lanes.clear();
        }
        let mut n_rings = 0;
        for (ring, colatitude) in colatitudes.enumerate() {
            halves[usize::from(colatitude.is_south())].lanes.push(ring, colatitude);
            n_rings += 1;
        }
        for half in &mut *halves {
            half.lanes.pad();
        }
        values.clear();
        values.resize(n_rings, Complex::ZERO);
        for m in 0..=self.lmax() {
            recurrence.fill(m, self.lmax());
            fourier(m, values);
            for Half { lanes, column } in &mut *halves {
                lanes.start_order(m, values);
                self.arch.dispatch(Column { lanes, recurrence, sums, out: column });
            }
            let [north, south] = &*halves;
            let pairs = north.column.iter().zip(&south.column).enumerate();
            for (a, (n, (north, south))) in out.column_mut(m).iter_mut().zip(pairs) {
                *a = if n.is_multiple_of(2) { north + south } else { north - south };
            }
        }
    }
}
