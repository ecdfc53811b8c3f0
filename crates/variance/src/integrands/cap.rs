use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_sh::{Colatitude, LegendrePlan};

use super::closed_form::{self, ClosedForm};
use super::drop_from_pole;
use crate::{Circle, Coefficients, Error, Integrand, Shape};

/// The indicator of the spherical cap within an angle of +z: the discontinuous test integrand.
///
/// `E(l) = pi (P_{l-1}(c) - P_{l+1}(c))^2/(2l+1)` with c the cosine of the angle (Singh 2015, C.10
/// as corrected). It is evaluated as `4 pi^2 sin^2 lambda_l1^2/(l(l+1))`, the same number by
/// `int_c^1 P_l = (1 - c^2) P_l'(c)/(l(l+1))`, which cancels nothing for any angle and degree. On
/// the hemisphere the even extension is the double cap, with four times the energy in even
/// degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    angle: f64,
    /// 1 - cos(angle).
    versine: f64,
    sin: f64,
}

impl Cap {
    /// The cap of all directions within `angle` (radians, in (0, pi]) of +z.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(angle: f64) -> Result<Self, Error> {
        if !(angle > 0.0 && angle <= PI) {
            return Err(Error::Parameter {
                name: "angle",
                range: "in (0, pi] radians",
                got: angle,
            });
        }
        let half = (0.5 * angle).sin();
        // The sine of the f64 nearest pi is not that of pi, but a cap of pi means the sphere.
        let sin = if angle < PI { angle.sin() } else { 0.0 };
        Ok(Self { angle, versine: 2.0 * half * half, sin })
    }

    /// The cap of `degrees`, in (0, 180].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn from_degrees(degrees: f64) -> Result<Self, Error> {
        if !(degrees > 0.0 && degrees <= 180.0) {
            return Err(Error::Parameter { name: "degrees", range: "in (0, 180]", got: degrees });
        }
        Self::new(degrees.to_radians().min(PI))
    }

    /// The half space `z >= height`, which leaves a cap of the sphere; `height` in [-1, 1).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn half_space(height: f64) -> Result<Self, Error> {
        if !(-1.0..1.0).contains(&height) {
            return Err(Error::Parameter { name: "height", range: "in [-1, 1)", got: height });
        }
        let (versine, rest) = (1.0 - height, 1.0 + height);
        Ok(Self { angle: height.acos(), versine, sin: (versine * rest).sqrt() })
    }

    /// The angle of the cap in radians.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// The shares of the domain inside and outside, neither of which is a difference from 1.
    fn shares(&self, domain: Domain) -> (f64, f64) {
        let half = (0.5 * self.angle).cos();
        // The f64 nearest pi and pi/2 have cosines that are not 0.
        match domain {
            _ if self.covers(domain) || self.angle >= PI => (1.0, 0.0),
            Domain::Sphere => (0.5 * self.versine, half * half),
            Domain::Hemisphere => (self.versine, self.angle.cos()),
        }
    }

    /// Whether the cap leaves nothing of the domain's boundary: all of the hemisphere.
    fn covers(&self, domain: Domain) -> bool {
        domain == Domain::Hemisphere && self.angle >= FRAC_PI_2
    }
}

/// The kurtosis of a function that has one value on the share `p` of a domain and another one on the share `q`:
/// `(p^3 + q^3)/(p q)`. `None` of a constant.
pub(super) fn two_valued_kurtosis(p: f64, q: f64) -> Option<f64> {
    (p > 0.0 && q > 0.0).then(|| (p * p - p * q + q * q) / (p * q))
}

impl ClosedForm for Cap {
    fn sphere_integral(&self) -> Option<f64> {
        Some(2.0 * PI * self.versine)
    }

    fn sphere_square(&self) -> Result<f64, Error> {
        Ok(2.0 * PI * self.versine)
    }

    /// `F_l0 = -2 pi sin lambda_l1/sqrt(l(l+1))`; the minus is the phase of `lambda_l1`.
    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let mut per_degree = vec![0.0; lmax + 1];
        if lmax >= 1 && self.sin > 0.0 {
            let colatitude = Colatitude::from_theta(self.angle)?;
            LegendrePlan::new(lmax)?.column_into(1, colatitude, &mut per_degree[1..]);
            for (l, c) in per_degree.iter_mut().enumerate().skip(1) {
                let l = l as f64;
                *c *= -2.0 * PI * self.sin / (l * (l + 1.0)).sqrt();
            }
        }
        per_degree[0] = PI.sqrt() * self.versine;
        Coefficients::zonal(DVec3::Z, per_degree)
    }
}

impl Integrand for Cap {
    fn eval(&self, dir: DVec3) -> f64 {
        if drop_from_pole(dir) <= self.versine { 1.0 } else { 0.0 }
    }

    fn shape(&self) -> Result<Shape, Error> {
        let edge = Circle { axis: DVec3::Z, angle: self.angle };
        let shape = Shape::smooth(0).zonal(DVec3::Z).within(edge);
        Ok(if self.sin > 0.0 { shape.with_edge(edge) } else { shape })
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        if self.covers(domain) { Some(domain.area()) } else { self.sphere_integral() }
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        if self.covers(domain) {
            let mut per_degree = vec![0.0; lmax + 1];
            per_degree[0] = (4.0 * PI).sqrt();
            return Coefficients::zonal(DVec3::Z, per_degree);
        }
        closed_form::coefficients(self, domain, lmax)
    }

    fn square(&self, domain: Domain) -> Result<f64, Error> {
        if self.covers(domain) { Ok(4.0 * PI) } else { closed_form::square(self, domain) }
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        let (inside, outside) = self.shares(domain);
        two_valued_kurtosis(inside, outside)
    }
}
