use std::f64::consts::TAU;

use glam::DVec3;

use crate::polar::{direction, drop_from_pole, half_open, turns};
use crate::{Error, Support, Warp, WarpSample};

/// The Phong lobe about +z, with density (n + 1)/(2 pi) cos^n(theta) on the hemisphere:
///
/// ```text
/// cos(theta) = (1 - u)^(1/(n + 1)),   phi = 2 pi v
/// ```
///
/// Round trips are accurate to 4e-15 for every exponent.
///
/// # Examples
///
/// ```
/// use sphvar_warps::{PhongLobe, Warp};
///
/// let lobe = PhongLobe::new(50.0)?;
/// assert!((lobe.density(glam::DVec3::Z) - 51.0 / std::f64::consts::TAU).abs() < 1e-14);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
///
/// # References
///
/// Lafortune and Willems 1994.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    exponent: f64,
}

impl PhongLobe {
    /// Returns the lobe of an exponent n in [0, 1e8]; 0 is the uniform hemisphere, 1 the cosine.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(exponent: f64) -> Result<Self, Error> {
        if !(0.0..=MAX_SHARPNESS).contains(&exponent) {
            return Err(Error::Parameter { name: "exponent", range: "in [0, 1e8]", got: exponent });
        }
        Ok(Self { exponent })
    }

    /// Returns the density at ln(cos(theta)).
    fn value(self, log_cos: f64) -> f64 {
        // 0 times the logarithm of 0 is NaN.
        let power = if self.exponent > 0.0 { (self.exponent * log_cos).exp() } else { 1.0 };
        (self.exponent + 1.0) / TAU * power
    }
}

/// Returns ln(cos(theta)) of a direction with z >= 0.
fn log_cos(dir: DVec3) -> f64 {
    if dir.z > 0.5 { (-drop_from_pole(dir)).ln_1p() } else { dir.z.ln() }
}

/// The largest exponent or concentration, a lobe of 0.006 degrees.
const MAX_SHARPNESS: f64 = 1e8;

impl Warp for PhongLobe {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let log_cos = (-u).ln_1p() / (self.exponent + 1.0);
        let point = direction(-log_cos.exp_m1(), log_cos.exp(), v);
        WarpSample { point, density: self.value(log_cos) }
    }

    fn density(&self, dir: DVec3) -> f64 {
        if dir.z >= 0.0 { self.value(log_cos(dir)) } else { 0.0 }
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let u = || -((self.exponent + 1.0) * log_cos(dir)).exp_m1();
        (dir.z >= 0.0).then(|| [half_open(u()), turns(dir)])
    }

    fn support(&self) -> Support {
        Support::UpperHemisphere
    }

    fn min_density(&self) -> f64 {
        if self.exponent > 0.0 { 0.0 } else { 1.0 / TAU }
    }
}

/// The von Mises-Fisher lobe about +z, with density kappa/(2 pi (1 - e^(-2 kappa))) e^(kappa (z -
/// 1)) on the sphere:
///
/// ```text
/// 1 - z = -ln(1 - u (1 - e^(-2 kappa)))/kappa,   phi = 2 pi v
/// ```
///
/// All terms are evaluated without cancellation, so round trips are accurate to 4e-15 for every
/// concentration from 0, the uniform sphere, to 1e8. The density is positive everywhere, but may
/// underflow to 0 in directions that no sample reaches.
///
/// # Examples
///
/// ```
/// use sphvar_warps::{VonMisesFisherLobe, Warp};
///
/// let lobe = VonMisesFisherLobe::new(1e6)?;
/// assert!(lobe.map([0.5, 0.0]).x < 2e-3);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
///
/// # References
///
/// Jakob 2012, "Numerically stable sampling of the von Mises-Fisher distribution on S^2".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMisesFisherLobe {
    kappa: f64,
    /// e^(-2 kappa) - 1.
    range: f64,
    /// The density at +z.
    peak: f64,
}

impl VonMisesFisherLobe {
    /// Returns the lobe of concentration `kappa` in [0, 1e8].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(kappa: f64) -> Result<Self, Error> {
        if !(0.0..=MAX_SHARPNESS).contains(&kappa) {
            return Err(Error::Parameter { name: "kappa", range: "in [0, 1e8]", got: kappa });
        }
        // Below the smallest normal number, 2 kappa/kappa has no digits; the limit is exact.
        let kappa = if kappa < f64::MIN_POSITIVE { 0.0 } else { kappa };
        let range = (-2.0 * kappa).exp_m1();
        let peak = if kappa > 0.0 { -kappa / (TAU * range) } else { 0.5 / TAU };
        Ok(Self { kappa, range, peak })
    }

    fn value(&self, drop: f64) -> f64 {
        self.peak * (-self.kappa * drop).exp()
    }
}

impl Warp for VonMisesFisherLobe {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let drop = if self.kappa > 0.0 {
            (-(u * self.range).ln_1p() / self.kappa).min(2.0)
        } else {
            2.0 * u
        };
        WarpSample { point: direction(drop, 1.0 - drop, v), density: self.value(drop) }
    }

    fn density(&self, dir: DVec3) -> f64 {
        self.value(drop_from_pole(dir))
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let drop = drop_from_pole(dir);
        let u =
            if self.kappa > 0.0 { (-self.kappa * drop).exp_m1() / self.range } else { 0.5 * drop };
        Some([half_open(u), turns(dir)])
    }

    fn support(&self) -> Support {
        Support::Sphere
    }

    fn min_density(&self) -> f64 {
        self.value(2.0)
    }
}
