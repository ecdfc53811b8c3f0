use glam::DVec3;
use sphvar_sh::{ByParity, Domain, real_ylm_at};

use super::{HarmonicProjection, check_domain};
use crate::{Coefficients, Energy, Error, Integrand, quadrature};

/// The integrand `f Y_lm` of one coefficient of a [`HarmonicProjection`], on the sphere only.
#[derive(Clone, Copy, Debug)]
pub struct ProjectedCoefficient<'a> {
    projection: &'a HarmonicProjection<'a>,
    index: usize,
    l: usize,
    m: i64,
}

impl<'a> ProjectedCoefficient<'a> {
    pub(super) fn new(
        projection: &'a HarmonicProjection<'a>,
        index: usize,
        l: usize,
        m: i64,
    ) -> Self {
        Self { projection, index, l, m }
    }

    fn harmonic(&self, dir: DVec3) -> f64 {
        real_ylm_at(self.l, self.m, dir).unwrap_or(f64::NAN)
    }
}

impl Integrand for ProjectedCoefficient<'_> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.projection.function.eval(dir) * self.harmonic(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.projection.function.eval_into(dirs, values)?;
        values.iter_mut().zip(dirs).for_each(|(value, &dir)| *value *= self.harmonic(dir));
        Ok(())
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        check_domain(domain).ok()?;
        Some(self.projection.exact()?[self.index])
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        check_domain(domain)?;
        let product = self.projection.product(self.l, self.m, lmax)?;
        Ok(Coefficients::general(product))
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        check_domain(domain)?;
        Ok(self.projection.centred_squares()?[self.index])
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.projection.weighted_energy(domain, lmax, &[(self.index, 1.0)])
    }

    /// Computed from values on a grid: features smaller than a degree may be missed.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        check_domain(domain).ok()?;
        let grid = self.projection.grid()?;
        let values: Vec<(f64, f64)> =
            grid.iter().map(|&(dir, weight, f)| (weight, f * self.harmonic(dir))).collect();
        quadrature::weighted_kurtosis(|| values.iter().copied())
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        self.projection.energy_seconds(domain, lmax)
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.projection.function.band_limit()? + self.l)
    }

    fn resolved_degree(&self) -> Option<usize> {
        Some(self.projection.function.resolved_degree()? + self.l)
    }
}
