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
        let transform = |epsilon| {
            Transform::new(Method::Auto, last_degree, n_points, epsilon)
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
