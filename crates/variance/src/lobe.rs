use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_sh::{Colatitude, GaussLegendre, LegendrePlan};

use crate::{Energy, Error, Integrand};

/// The von Mises-Fisher density about +z, `kappa/(2 pi (1 - e^{-2 kappa})) e^{kappa (z - 1)}`: a
/// smooth lobe with integral 1 over the sphere.
///
/// On the sphere `E(l) = (2l+1)/(4 pi) A_l^2`, where `A_l` is the ratio of modified Bessel functions
/// `I_{l+1/2}(kappa)/I_{1/2}(kappa)` (Mardia and Jupp 2000, section 9.3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMisesFisher {
    kappa: f64,
    /// The density at +z.
    peak: f64,
}

impl VonMisesFisher {
    /// The largest concentration, a lobe of 0.06 degrees.
    pub const MAX_KAPPA: f64 = 1e6;

    /// The lobe of concentration `kappa` in [0, 10^6]; 0 is the constant 1/(4 pi).
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

    /// `int_0^d e^{-rate s} ds`.
    fn falloff(rate: f64, d: f64) -> f64 {
        if rate > 0.0 { -(-rate * d).exp_m1() / rate } else { d }
    }

    /// `I_{l+1/2}/I_{1/2}` at kappa for l = 0 ..= lmax.
    ///
    /// The ratios of neighbours obey `1/r_{l-1} = (2l+1)/kappa + r_l`, which damps errors downwards.
    /// It starts where Amos's bounds (1974), `kappa/(nu + 1 + sqrt(kappa^2 + (nu + 1)^2))` above,
    /// has been damped to nothing, or at a degree whose ratio itself is nothing.
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

    /// The energies of the even extension, `f(|z|)`, by Gauss-Legendre quadrature over panels in
    /// 1 - z that double in width from the lobe's.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "degrees and node counts are small"
    )]
    fn hemisphere_energies(&self, lmax: usize) -> Result<Vec<f64>, Error> {
        let plan = LegendrePlan::new(lmax)?;
        let mut column = vec![0.0; lmax + 1];
        let mut coefficients = vec![0.0; lmax + 1];
        let (mut from, mut width) = (0.0, (2.0 / self.kappa).min(1.0));
        // Beyond 750/kappa the density is below the range of f64.
        while from < 1.0 && self.kappa * from < 750.0 {
            let to = f64::min(from + width, 1.0);
            // The phase of lambda_l0 moves by l dtheta; beyond half of that the error of the rule
            // falls faster than exponentially.
            let phase = lmax as f64 * (angle_of_drop(to) - angle_of_drop(from));
            let rule = GaussLegendre::new((0.5 * phase) as usize + 24)?;
            for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
                let half = 0.5 * (to - from);
                let drop = from + half * (1.0 + x);
                plan.column_into(0, Colatitude::from_theta(angle_of_drop(drop))?, &mut column);
                let weight = 4.0 * PI * w * half * self.peak * (-self.kappa * drop).exp();
                for (c, lambda) in coefficients.iter_mut().zip(&column) {
                    *c += weight * lambda;
                }
            }
            (from, width) = (to, 2.0 * width);
        }
        let even = |(l, c): (usize, f64)| if l.is_multiple_of(2) { c * c } else { 0.0 };
        Ok(coefficients.into_iter().enumerate().map(even).collect())
    }
}

/// The colatitude at height z = 1 - `drop`.
fn angle_of_drop(drop: f64) -> f64 {
    2.0 * (0.5 * drop).sqrt().asin()
}

impl Integrand for VonMisesFisher {
    fn eval(&self, dir: DVec3) -> f64 {
        let drop =
            if dir.z > 0.0 { (dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z) } else { 1.0 - dir.z };
        self.peak * (-self.kappa * drop).exp()
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        Some(match domain {
            Domain::Sphere => 1.0,
            Domain::Hemisphere => 1.0 / (1.0 + (-self.kappa).exp()),
        })
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let square = |height: f64| {
            2.0 * PI * self.peak * self.peak * Self::falloff(2.0 * self.kappa, height)
        };
        match domain {
            Domain::Sphere => {
                let energy = |(l, a): (usize, f64)| (2.0 * l as f64 + 1.0) / (4.0 * PI) * a * a;
                let per_degree =
                    self.bessel_ratios(lmax).into_iter().enumerate().map(energy).collect();
                Ok(Energy::new(domain, per_degree, square(2.0)))
            }
            Domain::Hemisphere => {
                Ok(Energy::new(domain, self.hemisphere_energies(lmax)?, 2.0 * square(1.0)))
            }
        }
    }
}
