use std::f64::consts::PI;

use glam::DVec3;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::closed_form::{self, ClosedForm};
use super::{drop_from_pole, exponential_degree, exponential_support};
use crate::definition::Definition;
use crate::{Circle, Coefficients, Error, Integrand, IntegrandResolver, Shape, quadrature};

/// The von Mises-Fisher density about +z, `kappa/(2 pi (1 - e^{-2 kappa})) e^{kappa (z - 1)}`: a
/// smooth lobe with integral 1 over the sphere.
///
/// On the sphere `E(l) = (2l+1)/(4 pi) A_l^2`, where `A_l` is the ratio of modified Bessel
/// functions `I_{l+1/2}(kappa)/I_{1/2}(kappa)` (Mardia and Jupp 2000, section 9.3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMisesFisher {
    kappa: f64,
    /// The density at +z.
    peak: f64,
}

impl VonMisesFisher {
    /// The largest concentration, a lobe of 0.06 degrees.
    pub const MAX_KAPPA: f64 = 1e6;

    /// Below this concentration the energies beyond [`WIDE_DEGREE`](Self::WIDE_DEGREE) are
    /// negligible: about `e^{-l^2/kappa}`.
    const WIDE: f64 = 8.0;
    const WIDE_DEGREE: usize = 64;

    /// Returns the lobe of concentration `kappa` in [0, 10^6]; 0 is the constant 1/(4 pi).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(kappa: f64) -> Result<Self, Error> {
        if !(0.0..=Self::MAX_KAPPA).contains(&kappa) {
            return Err(Error::Parameter { name: "kappa", range: "in [0, 1e6]", got: kappa });
        }
        let peak =
            if kappa > 0.0 { -kappa / (2.0 * PI * (-2.0 * kappa).exp_m1()) } else { 0.25 / PI };
        Ok(Self { kappa, peak })
    }

    /// `I_{l+1/2}/I_{1/2}` at kappa for l = 0 ..= lmax.
    ///
    /// The ratios of neighbours obey `1/r_{l-1} = (2l+1)/kappa + r_l`, which damps errors
    /// downwards. It starts where Amos's bounds (1974),
    /// `kappa/(nu + 1 + sqrt(kappa^2 + (nu + 1)^2))` above, is damped below rounding, or at a
    /// degree whose ratio is itself negligible.
    fn bessel_ratios(&self, lmax: usize) -> Vec<f64> {
        let kappa = self.kappa;
        let mut ratios = vec![0.0; lmax + 1];
        ratios[0] = 1.0;
        if kappa == 0.0 {
            return ratios;
        }
        let mut start = lmax;
        let mut damping = 1.0f64;
        while damping > 1e-20 {
            start += 1;
            let nu = start as f64 + 0.5;
            let r = kappa / (nu + (kappa * kappa + nu * nu).sqrt());
            damping *= r * r;
        }
        let nu = start as f64 + 1.5;
        let mut r = kappa / (nu + (kappa * kappa + nu * nu).sqrt());
        for l in (1..=start).rev() {
            // r is I_{l+1/2+1}/I_{l+1/2}; it becomes I_{l+1/2}/I_{l-1/2}.
            r = 1.0 / ((2.0 * l as f64 + 1.0) / kappa + r);
            if l <= lmax {
                ratios[l] = r;
            }
        }
        for l in 1..=lmax {
            ratios[l] *= ratios[l - 1];
        }
        ratios
    }
}

impl ClosedForm for VonMisesFisher {
    fn sphere_integral(&self) -> Option<f64> {
        Some(1.0)
    }

    /// With `c = kappa coth kappa` and `s = kappa/sinh kappa` the parts have
    /// `(c/2 + s^2/2 - 1)/(4 pi)` and `(c/2 - s^2/2)/(4 pi)`; for wide lobes, where these cancel,
    /// the result is the sum of the energies, which converges quickly.
    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        let kappa = self.kappa;
        if kappa < Self::WIDE {
            let mut sum = ByParity::both(0.0);
            // The smallest first.
            for (l, a) in self.bessel_ratios(Self::WIDE_DEGREE).iter().enumerate().skip(1).rev() {
                *sum.of_mut(l) += (2 * l + 1) as f64 / (4.0 * PI) * a * a;
            }
            return Ok(sum);
        }
        let q = (-kappa).exp();
        let (coth, csch) = ((1.0 + q * q) / (1.0 - q * q), 2.0 * q / (1.0 - q * q));
        let (c, s) = (0.5 * kappa * coth, 0.5 * (kappa * csch).powi(2));
        Ok(ByParity { even: c + s - 1.0, odd: c - s }.map(|x| x / (4.0 * PI)))
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let peak = |l: usize| ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
        let ratios = self.bessel_ratios(lmax).into_iter().enumerate();
        Coefficients::zonal(DVec3::Z, ratios.map(|(l, a)| peak(l) * a).collect())
    }
}

impl Integrand for VonMisesFisher {
    fn eval(&self, dir: DVec3) -> f64 {
        self.peak * (-self.kappa * drop_from_pole(dir)).exp()
    }

    fn shape(&self) -> Result<Shape, Error> {
        let shape = Shape::smooth(exponential_degree(self.kappa)).zonal(DVec3::Z);
        let angle = exponential_support(self.kappa);
        Ok(shape.within(Circle { axis: DVec3::Z, angle }))
    }

    /// On the hemisphere `1/(1 + e^{-kappa})`.
    fn exact(&self, domain: Domain) -> Option<f64> {
        Some(match domain {
            Domain::Sphere => 1.0,
            Domain::Hemisphere => 1.0 / (1.0 + (-self.kappa).exp()),
        })
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        if domain == Domain::Sphere || self.kappa >= Self::WIDE {
            return closed_form::coefficients(self, domain, lmax);
        }
        // The even extension of a wide lobe is nearly constant: the difference from the peak is
        // accurate.
        let below_peak = |dir: DVec3| self.peak * (-self.kappa * drop_from_pole(dir)).exp_m1();
        let rest = quadrature::coefficients(&self.shape()?, domain, lmax, &|dirs, values| {
            below_peak.eval_into(dirs, values)
        })?;
        let mut constant = vec![0.0; lmax + 1];
        constant[0] = self.peak * (4.0 * PI).sqrt();
        rest.plus(1.0, &Coefficients::zonal(DVec3::Z, constant)?)
    }

    /// On the hemisphere `(x coth x - 1)/(pi (1 + e^{-kappa})^2)` with x = kappa/2, by Lambert's
    /// continued fraction `x coth x = 1 + x^2/(3 + x^2/(5 + ...))` where the difference cancels.
    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        if domain == Domain::Sphere {
            return self.sphere_centred_square();
        }
        let (x, q) = (0.5 * self.kappa, (-self.kappa).exp());
        let excess = if self.kappa < Self::WIDE {
            (1..=20).rev().fold(0.0, |rest, k| x * x / (f64::from(2 * k + 1) + rest))
        } else {
            x * (1.0 + q) / (1.0 - q) - 1.0
        };
        Ok(ByParity { even: excess / (PI * (1.0 + q).powi(2)), odd: 0.0 })
    }
}

/// Parameters of a [`VonMisesFisher`] lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMisesFisherParameters {
    /// The concentration.
    pub kappa: f64,
}

/// An example.
impl Default for VonMisesFisherParameters {
    fn default() -> Self {
        Self { kappa: 10.0 }
    }
}

impl Parametric for VonMisesFisherParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::closed(0.0, VonMisesFisher::MAX_KAPPA);
        d.required_number("kappa", range, "concentration", &mut self.kappa);
    }
}

impl Definition for VonMisesFisherParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(VonMisesFisher::new(self.kappa)?))
    }
}
