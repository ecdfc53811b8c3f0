use glam::DVec3;
use sphvar_samplers::Domain;

use crate::{Energy, Error};

/// A real function of direction that is to be integrated over the sphere or the hemisphere.
///
/// Only [`eval`](Self::eval) is required, and closures `Fn(DVec3) -> f64` are integrands; what
/// else an integrand knows about itself turns a measurement into a test (the exact integral) or
/// makes a prediction possible (the energy).
pub trait Integrand: Sync {
    /// The value at a unit vector; on the hemisphere only vectors with z >= 0 are asked for.
    fn eval(&self, dir: DVec3) -> f64;

    /// The exact integral over the domain, if it is known.
    fn exact(&self, domain: Domain) -> Option<f64> {
        let _ = domain;
        None
    }

    /// The energy per degree up to `lmax`, and the total; on the hemisphere, that of the even
    /// extension.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if it is not known.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let _ = (domain, lmax);
        Err(Error::NoEnergy { reason: "it is given by its values only" })
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
