use glam::DVec3;
use sphvar_samplers::Domain;

use crate::{Coefficients, Energy, Error, Shape, quadrature};

/// A real function of direction that is to be integrated over the sphere or the hemisphere.
///
/// Only [`eval`](Self::eval) is required, and closures `Fn(DVec3) -> f64` are integrands; what
/// else an integrand knows about itself turns a measurement into a test (the exact integral) or
/// makes a prediction possible (the energy). An integrand that knows its [`shape`](Self::shape) has
/// everything else by quadrature, to rounding; one that has closed forms replaces what it can.
///
/// On the hemisphere F is the even extension of f from z >= 0 to the sphere.
pub trait Integrand: Sync {
    /// The value at a unit vector; on the hemisphere only vectors with z >= 0 are asked for.
    fn eval(&self, dir: DVec3) -> f64;

    /// Where the function is not smooth, and how fine it is elsewhere.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if that is not known.
    fn shape(&self) -> Result<Shape, Error> {
        Err(Error::NoEnergy { reason: "it is given by its values only" })
    }

    /// The exact integral of f over the domain, if it is known.
    fn exact(&self, domain: Domain) -> Option<f64> {
        quadrature::integral(&self.shape().ok()?, domain, &|dir| self.eval(dir)).ok()
    }

    /// The coefficients `F_lm` for l = 0 ..= `lmax`.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if they are not known, [`Error::Harmonics`] if `lmax` is out of range or
    /// memory.
    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        quadrature::coefficients(&self.shape()?, domain, lmax, &|dir| self.eval(dir))
    }

    /// `int F^2` over the sphere; on the hemisphere twice the integral of f^2.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if it is not known.
    fn square(&self, domain: Domain) -> Result<f64, Error> {
        quadrature::square(&self.shape()?, domain, &|dir| self.eval(dir))
    }

    /// The energy of F per degree up to `lmax`, and the total.
    ///
    /// # Errors
    ///
    /// Those of [`coefficients`](Self::coefficients) and [`square`](Self::square).
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let per_degree = self.coefficients(domain, lmax)?.energy_per_degree()?;
        Ok(Energy::new(domain, per_degree, self.square(domain)?))
    }

    /// The seconds that [`energy`](Self::energy) takes on one core, roughly: for progress only, and 0 where it is
    /// inexpensive or not known.
    fn energy_seconds(&self, _domain: Domain, _lmax: usize) -> f64 {
        0.0
    }

    /// The degree beyond which the integrand has no energy at all, if there is one.
    fn band_limit(&self) -> Option<usize> {
        None
    }

    /// A degree beyond which energies fall so fast (as l^-3 or faster) that a variance need not be
    /// summed much further, if there is one.
    fn resolved_degree(&self) -> Option<usize> {
        None
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> Integrand for F {
    fn eval(&self, dir: DVec3) -> f64 {
        self(dir)
    }
}

impl Integrand for Box<dyn Integrand> {
    fn eval(&self, dir: DVec3) -> f64 {
        (**self).eval(dir)
    }

    fn shape(&self) -> Result<Shape, Error> {
        (**self).shape()
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        (**self).exact(domain)
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        (**self).coefficients(domain, lmax)
    }

    fn square(&self, domain: Domain) -> Result<f64, Error> {
        (**self).square(domain)
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        (**self).energy(domain, lmax)
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        (**self).energy_seconds(domain, lmax)
    }

    fn band_limit(&self) -> Option<usize> {
        (**self).band_limit()
    }

    fn resolved_degree(&self) -> Option<usize> {
        (**self).resolved_degree()
    }
}
