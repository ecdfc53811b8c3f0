use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_sh::{Colatitude, LegendrePlan};

use crate::{Energy, Error, Integrand};

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

    /// Whether the cap leaves nothing of the domain's boundary: all of the hemisphere.
    fn covers(&self, domain: Domain) -> bool {
        domain == Domain::Hemisphere && self.angle >= FRAC_PI_2
    }
}

impl Integrand for Cap {
    fn eval(&self, dir: DVec3) -> f64 {
        // 1 - z without cancellation near the pole, where small caps live.
        let drop =
            if dir.z > 0.0 { (dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z) } else { 1.0 - dir.z };
        if drop <= self.versine { 1.0 } else { 0.0 }
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        Some(if self.covers(domain) { domain.area() } else { 2.0 * PI * self.versine })
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let area = 2.0 * PI * self.versine;
        let mut per_degree = vec![0.0; lmax + 1];
        if self.covers(domain) {
            per_degree[0] = 4.0 * PI;
            return Ok(Energy::new(domain, per_degree, 4.0 * PI));
        }
        per_degree[0] = area * area / (4.0 * PI);
        if lmax >= 1 && self.sin > 0.0 {
            let mut lambda = vec![0.0; lmax];
            LegendrePlan::new(lmax)?.column_into(
                1,
                Colatitude::from_theta(self.angle)?,
                &mut lambda,
            );
            for (l, lambda) in (1..).zip(lambda) {
                let coefficient = 2.0 * PI * self.sin * lambda;
                per_degree[l] = coefficient * coefficient / (l as f64 * (l as f64 + 1.0));
            }
        }
        // The even extension f(x) + f(-x) doubles even coefficients and has none of odd degree.
        let total = match domain {
            Domain::Sphere => area,
            Domain::Hemisphere => {
                double_even(&mut per_degree);
                2.0 * area
            }
        };
        Ok(Energy::new(domain, per_degree, total))
    }
}

/// The energies of `f(x) + f(-x)` from those of f.
pub(crate) fn double_even(per_degree: &mut [f64]) {
    for (l, e) in per_degree.iter_mut().enumerate() {
        *e *= if l.is_multiple_of(2) { 4.0 } else { 0.0 };
    }
}
