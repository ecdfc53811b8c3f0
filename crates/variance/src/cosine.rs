use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::Domain;

use crate::cap::double_even;
use crate::{Energy, Error, Integrand};

/// The clamped cosine max(0, z): the irradiance kernel of a surface facing +z, continuous with a
/// kink.
///
/// `F_l0 = sqrt(pi (2l+1)) c_l` with `c_l = int_0^1 t P_l(t) dt`: 1/2, 1/3, then 0 for odd l and
/// `-P_l(0)/((l-1)(l+2))` for even l. On the hemisphere the even extension is |z|.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClampedCosine;

impl Integrand for ClampedCosine {
    fn eval(&self, dir: DVec3) -> f64 {
        dir.z.max(0.0)
    }

    fn exact(&self, _: Domain) -> Option<f64> {
        Some(PI)
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let mut legendre_at_0 = 1.0;
        let mut per_degree: Vec<f64> = (0..=lmax)
            .map(|l| {
                let x = l as f64;
                let moment = match l {
                    0 => 0.5,
                    1 => 1.0 / 3.0,
                    _ if l % 2 == 1 => 0.0,
                    _ => {
                        legendre_at_0 *= -(x - 1.0) / x;
                        -legendre_at_0 / ((x - 1.0) * (x + 2.0))
                    }
                };
                PI * (2.0 * x + 1.0) * moment * moment
            })
            .collect();
        let mut total = 2.0 * PI / 3.0;
        if domain == Domain::Hemisphere {
            double_even(&mut per_degree);
            total *= 2.0;
        }
        Ok(Energy::new(domain, per_degree, total))
    }
}
