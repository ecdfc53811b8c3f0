use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_sh::{LmIndex, real_ylm_at};

use crate::{Energy, Error, Integrand};

/// A real orthonormal spherical harmonic, the band-limited test integrand: all its energy, 1, is
/// in one degree.
///
/// For m = 0 it is `Y_l0`; for m > 0 the cosine and for m < 0 the sine one, each with unit norm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Harmonic {
    l: usize,
    m: i64,
}

impl Harmonic {
    /// The harmonic of degree `l` and order `m`.
    ///
    /// # Errors
    ///
    /// [`Error::Order`] unless |m| <= l; [`Error::Harmonics`] beyond the degrees that can be evaluated.
    pub fn new(l: usize, m: i64) -> Result<Self, Error> {
        if m.unsigned_abs() > l as u64 {
            return Err(Error::Order { l, m });
        }
        LmIndex::new(l)?;
        Ok(Self { l, m })
    }
}

impl Integrand for Harmonic {
    fn eval(&self, dir: DVec3) -> f64 {
        real_ylm_at(self.l, self.m, dir).unwrap_or(f64::NAN)
    }

    /// On the hemisphere known for even degrees only.
    fn exact(&self, domain: Domain) -> Option<f64> {
        let mean = if self.l == 0 { 1.0 / (4.0 * PI).sqrt() } else { 0.0 };
        domain.has_degree(self.l).then_some(mean * domain.area())
    }

    /// On the hemisphere known for even degrees: the even extension of an odd harmonic has a kink
    /// on the equator and energy in every even degree.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        if !domain.has_degree(self.l) {
            return Err(Error::NoEnergy {
                reason: "a harmonic of odd degree is no function on the projective plane; take an even l",
            });
        }
        let mut per_degree = vec![0.0; lmax + 1];
        if let Some(e) = per_degree.get_mut(self.l) {
            *e = 1.0;
        }
        Ok(Energy::new(domain, per_degree, 1.0))
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.l)
    }
}
