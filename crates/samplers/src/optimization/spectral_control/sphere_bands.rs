use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::energy::{ACCURACIES, Band, BandTransform};
use super::target::SpectralTarget;
use crate::optimization::transforms;
use crate::{Domain, Error};

/// The degrees of spherical harmonics.
pub(crate) struct SphereBands {
    /// One for each of `ACCURACIES`.
    transforms: [Transform; ACCURACIES.len()],
    workspace: TransformWorkspace,
    alms: [Alm; 1],
    values: Vec<f64>,
}

impl SphereBands {
    pub(crate) fn new(last_degree: usize, n_points: usize) -> Result<Self, Error> {
        let method = method_with_gradients(n_points, last_degree);
        let transform = |epsilon| {
            Transform::new(method, last_degree, n_points, epsilon)
                .map_err(|error| Error::Degree { last: last_degree, reason: error.to_string() })
        };
        let alm = Alm::zeros(last_degree)
            .map_err(|error| Error::Degree { last: last_degree, reason: error.to_string() })?;
        let [a, b, c, d] = ACCURACIES;
        Ok(Self {
            transforms: [transform(a)?, transform(b)?, transform(c)?, transform(d)?],
            workspace: transforms::workspace(n_points),
            alms: [alm],
            values: vec![0.0; n_points],
        })
    }

    /// Returns the degrees that have a target, with `2l + 1` coefficients and the eigenvalues
    /// `l(l+1)`.
    pub(crate) fn targets(target: &SpectralTarget, domain: Domain) -> Vec<Band> {
        let band = |(l, target)| {
            let (multiplicity, eigenvalue) = ((2 * l + 1) as f64, (l * (l + 1)) as f64);
            Band { index: l, target, multiplicity, eigenvalue }
        };
        target.degrees(domain).map(band).collect()
    }
}

/// Returns the method by which coefficients and gradients together take less time, where
/// [`Method::Auto`] counts coefficients alone. In profiles exact gradients take four to five times as
/// long as exact coefficients; fast ones are taken to need twice as long as fast coefficients.
fn method_with_gradients(n_points: usize, lmax: usize) -> Method {
    const EXACT: f64 = 5.6;
    const FAST: f64 = 3.0;
    let exact = EXACT * Method::Exact.nominal_work(n_points, lmax);
    let fast = FAST * Method::Fast.nominal_work(n_points, lmax);
    if exact <= fast { Method::Exact } else { Method::Fast }
}

impl BandTransform for SphereBands {
    type Point = DVec3;

    const AREA: f64 = 4.0 * PI;

    fn analyze(&mut self, points: &[DVec3], level: usize, squares: &mut Vec<f64>) {
        let transform = &self.transforms[level];
        transform.adjoint_batch_into(&[(points, None)], &mut self.workspace, &mut self.alms);
        *squares = self.alms[0].energy_per_degree();
    }

    fn gradient_into(&mut self, factors: &[f64], points: &[DVec3], gradient: &mut [DVec3]) {
        let alm = &mut self.alms[0];
        for m in 0..=alm.lmax() {
            for (a, factor) in alm.column_mut(m).iter_mut().zip(&factors[m..]) {
                *a *= factor;
            }
        }
        let [transform, ..] = &self.transforms;
        transform.gradient_into(alm, points, &mut self.workspace, &mut self.values, gradient);
    }
}
