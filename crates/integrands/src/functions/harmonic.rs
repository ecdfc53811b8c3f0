use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::DVec3;
use num_complex::Complex;
use sphvar_grammar::{Declaration, Parametric};
use sphvar_sh::Domain;
use sphvar_sh::{Alm, ByParity, LmIndex, real_ylm_at};

use crate::definition::Definition;
use crate::{Coefficients, Energy, Error, Integrand, IntegrandResolver, Shape, quadrature};

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
    /// Returns the harmonic of degree `l` and order `m`.
    ///
    /// # Errors
    ///
    /// [`Error::Order`] unless |m| <= l; [`Error::Harmonics`] beyond the supported degrees.
    pub fn new(l: usize, m: i64) -> Result<Self, Error> {
        if m.unsigned_abs() > l as u64 {
            return Err(Error::Order { l, m });
        }
        LmIndex::new(l)?;
        Ok(Self { l, m })
    }

    /// Rejects odd degrees on the hemisphere.
    fn check(&self, domain: Domain) -> Result<(), Error> {
        if domain.has_degree(self.l) {
            return Ok(());
        }
        Err(Error::NoEnergy {
            reason: "a harmonic of odd degree is not antipodal, as functions on the hemisphere are; use an even l",
        })
    }
}

impl Integrand for Harmonic {
    fn eval(&self, dir: DVec3) -> f64 {
        real_ylm_at(self.l, self.m, dir).unwrap_or(f64::NAN)
    }

    fn shape(&self) -> Result<Shape, Error> {
        // The recurrence takes l steps.
        let shape = Shape::smooth(self.l).with_cost(1.0 + self.l as f64 / 8.0);
        let shape = if self.m == 0 { shape.zonal(DVec3::Z) } else { shape };
        Ok(if self.l.is_multiple_of(2) { shape.even() } else { shape })
    }

    /// On the hemisphere available for even degrees only.
    fn exact(&self, domain: Domain) -> Option<f64> {
        let mean = if self.l == 0 { 1.0 / (4.0 * PI).sqrt() } else { 0.0 };
        domain.has_degree(self.l).then_some(mean * domain.area())
    }

    /// Returns one coefficient for m = 0, two of size `1/sqrt 2` else. On the hemisphere as the
    /// energy.
    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        self.check(domain)?;
        if self.m == 0 {
            let mut per_degree = vec![0.0; lmax + 1];
            if let Some(c) = per_degree.get_mut(self.l) {
                *c = 1.0;
            }
            return Coefficients::zonal(DVec3::Z, per_degree);
        }
        let mut alm = Alm::zeros(lmax)?;
        let order = usize::try_from(self.m.unsigned_abs()).unwrap_or(usize::MAX);
        if self.l <= lmax {
            // sqrt(2) times the real or the imaginary part of Y_l|m|.
            alm[(self.l, order)] = match self.m {
                1.. => Complex::new(FRAC_1_SQRT_2, 0.0),
                _ => Complex::new(0.0, -FRAC_1_SQRT_2),
            };
        }
        Ok(Coefficients::general(alm))
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        self.check(domain)?;
        let mut centred = ByParity::both(0.0);
        if self.l > 0 {
            *centred.of_mut(self.l) = 1.0;
        }
        Ok(centred)
    }

    /// On the hemisphere known for even degrees: the even extension of an odd harmonic has a kink
    /// on the equator and energy in every even degree.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.check(domain)?;
        let mut per_degree = vec![0.0; lmax + 1];
        if let Some(e) = per_degree.get_mut(self.l) {
            *e = 1.0;
        }
        Ok(Energy::new(domain, per_degree, self.centred_square(domain)?))
    }

    /// Available up to degree 128; beyond it the recurrence for a value is too long.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        const MAX_DEGREE: usize = 128;
        let shape = self.shape().ok().filter(|_| self.l <= MAX_DEGREE)?;
        quadrature::kurtosis(&shape, domain, &|dirs, values| self.eval_into(dirs, values))
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.l)
    }
}

/// Parameters of a [`Harmonic`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HarmonicParameters {
    /// The degree.
    pub l: usize,
    /// The order, from -l to l.
    pub m: i64,
}

/// An example.
impl Default for HarmonicParameters {
    fn default() -> Self {
        Self { l: 4, m: 0 }
    }
}

impl Parametric for HarmonicParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_integer("l", [0, i64::MAX], "degree", &mut self.l);
        d.integer("m", [i64::MIN, i64::MAX], "order, from -l to l", &mut self.m);
    }
}

impl Definition for HarmonicParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(Harmonic::new(self.l, self.m)?))
    }
}
