use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::{ByParity, Domain};

use super::{HarmonicProjection, check_domain};
use crate::{ClampedCosine, Energy, Error, Integrand, VectorIntegrand};

/// The irradiance over all normals that follows from a [`HarmonicProjection`], known by its energies.
///
/// With the coefficients `F_lm` of the radiance (Ramamoorthi and Hanrahan 2001, equation 7)
///
/// ```text
/// E(n) = sum_lm A_l F_lm Y_lm(n),   A_0 = pi, A_1 = 2 pi/3, A_2 = pi/4, A_3 = 0, A_4 = -pi/24, ...
/// ```
///
/// so that the mean squared error of the irradiance, integrated over all normals, is
/// `sum_lm A_l^2 Var(F_lm)`: the variance of an integrand with the energies
/// `sum_lm A_l^2 E_lm(L)` of the products `f Y_lm`, which are its [`energy`](Integrand::energy).
/// The error of leaving out higher degrees is no part of it.
///
/// As an [`Integrand`] it is on the sphere only and has no values. Instead of an integral,
/// [`exact`](Integrand::exact) is the norm `sqrt(int E^2)` over all normals, so that relative
/// errors are those relative to the root-mean-square irradiance. Trials of the projection measure
/// it with the [`weights`](Self::weights).
#[derive(Clone, Debug)]
pub struct Irradiance<'a> {
    projection: &'a HarmonicProjection<'a>,
    weights: Vec<f64>,
}

impl<'a> Irradiance<'a> {
    pub(super) fn new(projection: &'a HarmonicProjection<'a>) -> Self {
        // The convolution theorem for the clamped cosine.
        let cosine = ClampedCosine.coefficients(Domain::Sphere, projection.degree());
        let cosine = cosine.ok().and_then(|c| Some(c.as_zonal()?.1.to_vec())).unwrap_or_default();
        let factor = |l: usize| cosine[l] * (4.0 * PI / (2 * l + 1) as f64).sqrt();
        let weights = projection.orders().map(|(l, _)| factor(l)).collect();
        Self { projection, weights }
    }

    /// Returns the factors `A_l` of the coefficients, in the order of the components.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the components with the squares of their factors.
    fn squares(&self) -> Vec<(usize, f64)> {
        self.weights.iter().map(|a| a * a).enumerate().collect()
    }
}

impl Integrand for Irradiance<'_> {
    /// NaN: the irradiance is a sum of integrals, not one.
    fn eval(&self, _: DVec3) -> f64 {
        f64::NAN
    }

    /// Returns an error: the values are those of the components of the projection.
    fn eval_into(&self, _: &[DVec3], _: &mut [f64]) -> Result<(), Error> {
        let components = self.projection.components();
        let reason = format!("the irradiance follows from {components} integrals");
        Err(Error::Evaluation { reason })
    }

    /// Returns the norm of the irradiance over all normals.
    fn exact(&self, domain: Domain) -> Option<f64> {
        check_domain(domain).ok()?;
        let exact = self.projection.exact()?.iter().zip(&self.weights);
        Some(exact.map(|(f, a)| (a * f) * (a * f)).sum::<f64>().sqrt())
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        check_domain(domain)?;
        let all = self.projection.centred_squares()?;
        Ok(self.squares().iter().fold(ByParity::both(0.0), |sum, &(component, square)| {
            sum.zip(all[component]).map(|(sum, e)| sum + square * e)
        }))
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.projection.weighted_energy(domain, lmax, &self.squares())
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        self.projection.energy_seconds(domain, lmax)
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.projection.function.band_limit()? + self.projection.degree())
    }

    fn resolved_degree(&self) -> Option<usize> {
        Some(self.projection.function.resolved_degree()? + self.projection.degree())
    }
}
