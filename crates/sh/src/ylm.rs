use core::f64::consts::SQRT_2;

use glam::DVec3;
use num_complex::Complex;

use crate::{Colatitude, Error, MAX_DEGREE, lambda};

/// Maximum deviation of the squared length of a direction from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Returns the spherical harmonic `Y_lm(theta, phi)`, orthonormal, with the Condon-Shortley phase.
///
/// ```text
/// Y_lm = lambda_lm(theta) e^(i m phi),   Y_{l,-m} = (-1)^m conj Y_lm,   integral |Y_lm|^2 = 1
/// ```
///
/// Domain: `l <=` [`MAX_DEGREE`], `-l <= m <= l`, `theta` in `[0, PI]`, `phi` finite; radians.
/// The result is finite at the poles; it is 0 at `theta = 0` for `m != 0`. The product `m phi` is
/// exact, so the accuracy is that of [`lambda`](crate::lambda()) plus a few `EPSILON`.
///
/// # Errors
///
/// [`Error::DegreeTooLarge`], [`Error::Order`], [`Error::Colatitude`], [`Error::Longitude`].
///
/// # Performance
///
/// `O(l)`, no allocation.
///
/// # Examples
///
/// ```
/// use sphvar_sh::ylm;
///
/// let (theta, phi) = (0.7_f64, 1.9_f64);
/// let amplitude = (3.0 / (8.0 * std::f64::consts::PI)).sqrt() * theta.sin();
/// let y = ylm(1, 1, theta, phi)?;
/// assert!((y.re + amplitude * phi.cos()).abs() < 1e-15);
/// assert!((y.im + amplitude * phi.sin()).abs() < 1e-15);
/// assert_eq!(ylm(1, -1, theta, phi)?, -y.conj());
/// assert!(ylm(1, 2, theta, phi).is_err());
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// Jackson, "Classical Electrodynamics", 3rd edition 1998, equations 3.53 and 3.54.
pub fn ylm(l: usize, m: i64, theta: f64, phi: f64) -> Result<Complex<f64>, Error> {
    let order = checked_order(l, m)?;
    let amplitude = lambda(l, order, Colatitude::from_theta(theta)?);
    let (cos, sin) = cos_sin_multiple(order, phi)?;
    Ok(with_order_sign(m, amplitude, cos, sin))
}

/// Returns [`ylm`] at a unit vector.
///
/// The longitude is `atan2(y, x)`; its rounding error, at most about 2 `EPSILON`, is multiplied by
/// `m`. At the poles the result is 0 for `m != 0`.
///
/// # Errors
///
/// [`Error::DegreeTooLarge`]; [`Error::Order`]; [`Error::Direction`] if the squared length differs
/// from 1 by more than `1e-6` or is not finite.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_sh::{ylm, ylm_at};
///
/// let y = ylm_at(5, -3, DVec3::new(0.6, 0.0, -0.8))?;
/// let same = ylm(5, -3, 0.6_f64.atan2(-0.8), 0.0)?;
/// assert!((y - same).norm() < 1e-15);
/// assert_eq!(ylm_at(5, -3, DVec3::NEG_Z)?.norm(), 0.0);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
pub fn ylm_at(l: usize, m: i64, dir: DVec3) -> Result<Complex<f64>, Error> {
    let order = checked_order(l, m)?;
    let (colatitude, phi) = checked_direction(dir)?;
    let (cos, sin) = cos_sin_multiple(order, phi)?;
    Ok(with_order_sign(m, lambda(l, order, colatitude), cos, sin))
}

/// Returns the real spherical harmonic of degree `l` and order `m`, orthonormal.
///
/// ```text
/// m = 0:  lambda_l0
/// m > 0:  sqrt(2) lambda_lm cos(m phi)       = sqrt(2) Re Y_lm
/// m < 0:  sqrt(2) lambda_l|m| sin(|m| phi)   = sqrt(2) Im Y_l|m|
/// ```
///
/// The Condon-Shortley phase is included, as it is in `lambda`: for odd `|m|` the sign is opposite
/// to the convention common in graphics. Degree 1 is `sqrt(3/(4 pi)) (-y, z, -x)` for
/// m = -1, 0, 1.
///
/// Domain, accuracy and cost are those of [`ylm`].
///
/// # Errors
///
/// Those of [`ylm`].
///
/// # Examples
///
/// ```
/// use sphvar_sh::real_ylm;
///
/// let (theta, phi) = (1.1_f64, 0.2_f64);
/// let y = -(3.0 / (4.0 * std::f64::consts::PI)).sqrt() * theta.sin() * phi.sin();
/// assert!((real_ylm(1, -1, theta, phi)? - y).abs() < 1e-15);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
pub fn real_ylm(l: usize, m: i64, theta: f64, phi: f64) -> Result<f64, Error> {
    let order = checked_order(l, m)?;
    let amplitude = lambda(l, order, Colatitude::from_theta(theta)?);
    let (cos, sin) = cos_sin_multiple(order, phi)?;
    Ok(real_part(m, amplitude, cos, sin))
}

/// Returns [`real_ylm`] at a unit vector; the accuracy of the longitude is that of [`ylm_at`].
///
/// # Errors
///
/// Those of [`ylm_at`].
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_sh::real_ylm_at;
///
/// let y = real_ylm_at(1, 1, DVec3::X)?;
/// assert!((y + (3.0 / (4.0 * std::f64::consts::PI)).sqrt()).abs() < 1e-15);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
pub fn real_ylm_at(l: usize, m: i64, dir: DVec3) -> Result<f64, Error> {
    let order = checked_order(l, m)?;
    let (colatitude, phi) = checked_direction(dir)?;
    let (cos, sin) = cos_sin_multiple(order, phi)?;
    Ok(real_part(m, lambda(l, order, colatitude), cos, sin))
}

/// Returns `|m|` if `(l, m)` is valid.
fn checked_order(l: usize, m: i64) -> Result<usize, Error> {
    if l > MAX_DEGREE {
        return Err(Error::DegreeTooLarge { lmax: l, max: MAX_DEGREE });
    }
    usize::try_from(m.unsigned_abs()).ok().filter(|&order| order <= l).ok_or(Error::Order { l, m })
}

/// Returns colatitude and longitude of a unit vector.
fn checked_direction(dir: DVec3) -> Result<(Colatitude, f64), Error> {
    // This form rejects NaN.
    if (dir.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        Ok((Colatitude::from_direction(dir), dir.y.atan2(dir.x)))
    } else {
        Err(Error::Direction { x: dir.x, y: dir.y, z: dir.z })
    }
}

/// Returns `cos(m phi)` and `sin(m phi)`.
///
/// The product is split into its rounded value and the exact rest, computed by `mul_add`.
fn cos_sin_multiple(m: usize, phi: f64) -> Result<(f64, f64), Error> {
    let m = m as f64;
    let product = m * phi;
    if !phi.is_finite() || !product.is_finite() {
        return Err(Error::Longitude { phi });
    }
    let (sin, cos) = product.sin_cos();
    let (rest_sin, rest_cos) = m.mul_add(phi, -product).sin_cos();
    Ok((cos * rest_cos - sin * rest_sin, sin * rest_cos + cos * rest_sin))
}

/// Returns `Y_lm` from `lambda_l|m|` and the angle `|m| phi`.
fn with_order_sign(m: i64, amplitude: f64, cos: f64, sin: f64) -> Complex<f64> {
    match (m < 0, m % 2 == 0) {
        (false, _) => Complex::new(amplitude * cos, amplitude * sin),
        (true, true) => Complex::new(amplitude * cos, -(amplitude * sin)),
        (true, false) => Complex::new(-(amplitude * cos), amplitude * sin),
    }
}

/// Returns the real harmonic from `lambda_l|m|` and the angle `|m| phi`.
fn real_part(m: i64, amplitude: f64, cos: f64, sin: f64) -> f64 {
    match m {
        0 => amplitude,
        1.. => SQRT_2 * amplitude * cos,
        _ => SQRT_2 * amplitude * sin,
    }
}
