use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Alm, Domain, Error};

use crate::{FastTransform, Method, Transform, TransformWorkspace};

/// The matrix B of all harmonics of the domain up to a degree at points, one row per harmonic, as a
/// pair of transforms.
pub(crate) struct Harmonics<'a> {
    points: &'a [DVec3],
    domain: Domain,
    lmax: usize,
    transform: Transform,
    workspace: TransformWorkspace,
}

impl<'a> Harmonics<'a> {
    pub(crate) fn new(points: &'a [DVec3], domain: Domain, lmax: usize) -> Result<Self, Error> {
        // Residuals cannot be less than the error of the transform.
        let epsilon = FastTransform::MIN_EPSILON;
        let transform = Transform::new(Method::Auto, lmax, points.len(), epsilon)?;
        Ok(Self { points, domain, lmax, transform, workspace: TransformWorkspace::parallel() })
    }

    pub(crate) fn n_points(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn domain(&self) -> Domain {
        self.domain
    }

    pub(crate) fn zeros(&self) -> Result<Alm, Error> {
        Alm::zeros(self.lmax)
    }

    /// Writes `B^T a`, the values of a function at the points.
    pub(crate) fn values(&mut self, alm: &Alm, out: &mut [f64]) {
        self.transform.synthesis_into(alm, self.points, &mut self.workspace, out);
    }

    /// Writes `B w`, the coefficients of weighted points; those of degrees that the domain does not
    /// have are 0.
    pub(crate) fn coefficients(&mut self, weights: &[f64], out: &mut Alm) {
        let set = (self.points, Some(weights));
        let outs = std::slice::from_mut(out);
        self.transform.adjoint_batch_into(&[set], &mut self.workspace, outs);
        project(self.domain, out);
    }
}

/// Removes what coefficients of a real function on the domain do not have: the imaginary parts of
/// order 0, and degrees that the domain lacks.
pub(crate) fn project(domain: Domain, alm: &mut Alm) {
    // Transforms leave rounding errors there, on which synthesis does not depend, so that no
    // iteration could reduce them.
    alm.column_mut(0).iter_mut().for_each(|a| a.im = 0.0);
    for m in 0..=alm.lmax() {
        for (l, a) in (m..).zip(alm.column_mut(m)) {
            if !domain.has_degree(l) {
                *a = Complex::ZERO;
            }
        }
    }
}

/// Returns the inner product of real functions with these coefficients; orders m > 0 stand for m
/// and -m.
pub(crate) fn dot(a: &Alm, b: &Alm) -> f64 {
    let (zonal, others) = (0..=a.lmax()).map(|m| (m, a.column(m).iter().zip(b.column(m)))).fold(
        (0.0, 0.0),
        |(zonal, others), (m, pairs)| {
            let sum: f64 = pairs.map(|(a, b)| a.re * b.re + a.im * b.im).sum();
            if m == 0 { (zonal + sum, others) } else { (zonal, others + sum) }
        },
    );
    zonal + 2.0 * others
}

/// Adds `factor b` to `a`.
pub(crate) fn add(a: &mut Alm, factor: f64, b: &Alm) {
    for (a, b) in a.values_mut().iter_mut().zip(b.values()) {
        *a += factor * b;
    }
}
