use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::Domain;
use sphvar_sh::{ByParity, Colatitude, LegendrePlan};

use super::closed_form::{self, ClosedForm};
use super::drop_from_pole;
use crate::definition::Definition;
use crate::{Circle, Coefficients, Error, Integrand, IntegrandResolver, Shape};

/// The indicator of the spherical cap within an angle of +z: the discontinuous test integrand.
///
/// `E(l) = pi (P_{l-1}(c) - P_{l+1}(c))^2/(2l+1)` with c the cosine of the angle (Singh 2015, C.10
/// as corrected). It is evaluated as `4 pi^2 sin^2 lambda_l1^2/(l(l+1))`, the same number by
/// `int_c^1 P_l = (1 - c^2) P_l'(c)/(l(l+1))`, which avoids cancellation for any angle and degree.
/// A cap beyond 90 degrees is the sphere minus the complementary cap, which has the same energies
/// for l >= 1. On the hemisphere the even extension is the double cap, with four times the energy
/// in even degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    angle: f64,
    /// 1 - cos(angle) and 1 + cos(angle), each to full precision.
    versine: f64,
    coversine: f64,
    sin: f64,
    cos: f64,
}

impl Cap {
    /// Returns the cap of all directions within `angle` (radians, in (0, pi]) of +z.
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
        // The sine of the f64 nearest pi is not that of pi, but a cap of pi means the sphere.
        let [from_pole, from_equator] = [angle, FRAC_PI_2 - angle];
        let complement = if angle < PI { PI - angle } else { 0.0 };
        Ok(Self::from_angles(from_pole, from_equator, complement))
    }

    /// Returns the cap of an angle; the angle, 90 degrees minus it and 180 degrees minus it are
    /// given to full precision.
    fn from_angles(angle: f64, from_equator: f64, complement: f64) -> Self {
        let versine = |x: f64| 2.0 * (0.5 * x).sin().powi(2);
        Self {
            angle,
            versine: versine(angle),
            coversine: versine(complement),
            sin: angle.min(complement).sin(),
            cos: from_equator.sin(),
        }
    }

    /// Returns the cap of `degrees`, in (0, 180].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn from_degrees(degrees: f64) -> Result<Self, Error> {
        if !(degrees > 0.0 && degrees <= 180.0) {
            return Err(Error::Parameter { name: "degrees", range: "in (0, 180]", got: degrees });
        }
        // Differences of degrees near 90 and 180 have no rounding.
        let [angle, from_equator, complement] =
            [degrees, 90.0 - degrees, 180.0 - degrees].map(f64::to_radians);
        Ok(Self::from_angles(angle.min(PI), from_equator, complement))
    }

    /// Returns the half space `z >= height`, whose intersection with the sphere is a cap; `height`
    /// in [-1, 1).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn half_space(height: f64) -> Result<Self, Error> {
        if !(-1.0..1.0).contains(&height) {
            return Err(Error::Parameter { name: "height", range: "in [-1, 1)", got: height });
        }
        let (versine, coversine) = (1.0 - height, 1.0 + height);
        let sin = (versine * coversine).sqrt();
        Ok(Self { angle: sin.atan2(height), versine, coversine, sin, cos: height })
    }

    /// Returns the angle of the cap in radians.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Returns the smaller of the versines of the cap and of its complement.
    fn lesser_versine(&self) -> f64 {
        self.versine.min(self.coversine)
    }

    /// Returns the fractions of the domain inside and outside, neither computed as a difference
    /// from 1.
    fn shares(&self, domain: Domain) -> (f64, f64) {
        let half = (0.5 * self.angle).cos();
        // The f64 nearest pi and pi/2 have cosines that are not 0.
        match domain {
            _ if self.covers(domain) || self.angle >= PI => (1.0, 0.0),
            Domain::Sphere => (0.5 * self.versine, half * half),
            Domain::Hemisphere => (self.versine, self.angle.cos()),
        }
    }

    /// Returns whether the cap covers the whole hemisphere, so that no edge remains.
    fn covers(&self, domain: Domain) -> bool {
        domain == Domain::Hemisphere && self.cos <= 0.0
    }
}

/// Returns the kurtosis of a function with one value on a fraction `p` of the domain and another on
/// a fraction `q`: `(p^3 + q^3)/(p q)`. `None` for a constant.
pub(crate) fn two_valued_kurtosis(p: f64, q: f64) -> Option<f64> {
    (p > 0.0 && q > 0.0).then(|| (p * p - p * q + q * q) / (p * q))
}

impl ClosedForm for Cap {
    fn sphere_integral(&self) -> Option<f64> {
        Some(2.0 * PI * self.versine)
    }

    /// Returns the odd part is 1/2 and -1/2 in the smaller of cap and complement and at its
    /// antipodes. Both parts together have `A (4 pi - A)/(4 pi) = pi sin^2`, A being the area.
    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        let odd = PI * self.lesser_versine();
        Ok(ByParity { even: odd * self.cos.abs(), odd })
    }

    /// `F_l0 = -2 pi sin lambda_l1/sqrt(l(l+1))`; the sign is the phase of `lambda_l1`. Beyond 90
    /// degrees `lambda_l1(pi - t) = (-1)^{l+1} lambda_l1(t)`.
    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let mut per_degree = vec![0.0; lmax + 1];
        if lmax >= 1 && self.sin > 0.0 {
            let near = Colatitude::from_direction(DVec3::new(self.sin, 0.0, self.cos.abs()));
            let even_sign = if self.cos < 0.0 { -1.0 } else { 1.0 };
            LegendrePlan::new(lmax)?.column_into(1, near, &mut per_degree[1..]);
            for (l, c) in per_degree.iter_mut().enumerate().skip(1) {
                let sign = if l.is_multiple_of(2) { even_sign } else { 1.0 };
                let l = l as f64;
                *c *= -2.0 * sign * PI * self.sin / (l * (l + 1.0)).sqrt();
            }
        }
        per_degree[0] = PI.sqrt() * self.versine;
        Coefficients::zonal(DVec3::Z, per_degree)
    }
}

impl Integrand for Cap {
    fn eval(&self, dir: DVec3) -> f64 {
        let is_inside = if self.cos < 0.0 {
            drop_from_pole(-dir) >= self.coversine
        } else {
            drop_from_pole(dir) <= self.versine
        };
        f64::from(u8::from(is_inside))
    }

    fn shape(&self) -> Result<Shape, Error> {
        let edge = Circle { axis: DVec3::Z, angle: self.angle };
        let shape = Shape::smooth(0).zonal(DVec3::Z);
        // The whole sphere is a constant.
        Ok(if self.sin > 0.0 { shape.within(edge).with_edge(edge) } else { shape.even() })
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

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        if self.covers(domain) {
            return Ok(ByParity::both(0.0));
        }
        closed_form::centred_square(self, domain)
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        let (inside, outside) = self.shares(domain);
        two_valued_kurtosis(inside, outside)
    }
}

/// Parameters of a [`Cap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CapParameters {
    /// The angle from +z, see [`Cap::from_degrees`].
    pub degrees: f64,
}

/// An example.
impl Default for CapParameters {
    fn default() -> Self {
        Self { degrees: 60.0 }
    }
}

impl Parametric for CapParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::left_open(0.0, 180.0);
        d.required_number("degrees", range, "angle from +z", &mut self.degrees);
    }
}

impl Definition for CapParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(Cap::from_degrees(self.degrees)?))
    }
}
