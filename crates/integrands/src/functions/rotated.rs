use glam::{DMat3, DQuat, DVec3};
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::closed_form::{ClosedForm, from_closed_form};
use crate::quadrature::{self, Estimates};
use crate::shape::Fold;
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// An integrand after a rotation R of the sphere, `f(R^-1 x)`.
///
/// On the sphere the integral and energies are unchanged. On the hemisphere they follow from those
/// for even functions and for functions that vanish below the equator, and otherwise from
/// quadrature with the equator as an edge.
///
/// # Examples
///
/// ```
/// use glam::DQuat;
/// use sphvar_integrands::{Cap, Domain, Integrand, Rotated};
///
/// let cap = Cap::from_degrees(30.0)?;
/// let rotated = Rotated::new(cap, DQuat::from_rotation_x(0.7))?;
/// assert_eq!(rotated.exact(Domain::Sphere), cap.exact(Domain::Sphere));
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rotated<I> {
    function: I,
    quaternion: DQuat,
    /// The rotation as a matrix.
    rotation: DMat3,
    estimates: Estimates,
}

impl<I: Integrand> Rotated<I> {
    /// Returns `function` after `rotation`, which is normalized.
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if `rotation` is zero or not finite.
    pub fn new(function: I, rotation: DQuat) -> Result<Self, Error> {
        let length = rotation.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Error::Rotation { length });
        }
        let quaternion = rotation.normalize();
        Ok(Self {
            function,
            quaternion,
            rotation: DMat3::from_quat(quaternion),
            estimates: Estimates::default(),
        })
    }

    /// Returns `function` rotated by `psi` about +z and then by the rotation that takes +z to
    /// colatitude `theta` and longitude `phi`, all in radians.
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if an angle is not finite.
    pub fn to_angles(function: I, theta: f64, phi: f64, psi: f64) -> Result<Self, Error> {
        Self::new(function, rotation_to_angles(theta, phi, psi))
    }

    /// Returns this integrand after a further rotation. Both are combined, so a chain of any length
    /// costs the same as one rotation.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new).
    pub fn then(self, rotation: DQuat) -> Result<Self, Error> {
        Self::new(self.function, rotation * self.quaternion)
    }

    /// This integrand after a further rotation by angles, as for [`to_angles`](Self::to_angles).
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if an angle is not finite.
    pub fn then_to_angles(self, theta: f64, phi: f64, psi: f64) -> Result<Self, Error> {
        self.then(rotation_to_angles(theta, phi, psi))
    }
}

/// Returns the rotation by `psi` about +z followed by the one that takes +z to colatitude `theta`
/// and longitude `phi`.
pub(crate) fn rotation_to_angles(theta: f64, phi: f64, psi: f64) -> DQuat {
    let tilt = DQuat::from_rotation_z(phi) * DQuat::from_rotation_y(theta);
    tilt * DQuat::from_rotation_z(psi)
}

impl<I: Integrand> ClosedForm for Rotated<I> {
    fn sphere_integral(&self) -> Option<f64> {
        self.function.exact(Domain::Sphere)
    }

    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        self.function.centred_square(Domain::Sphere)
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        self.function.coefficients(Domain::Sphere, lmax)?.rotated(self.rotation)
    }
}

impl<I: Integrand> Integrand for Rotated<I> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.function.eval((self.rotation.transpose() * dir).normalize())
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let back = |dir: &DVec3| (self.rotation.transpose() * *dir).normalize();
        let rotated: Vec<DVec3> = dirs.iter().map(back).collect();
        self.function.eval_into(&rotated, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(self.function.shape()?.rotated(self.rotation))
    }

    from_closed_form!();

    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        if domain == Domain::Sphere {
            return self.function.integral_estimate(domain);
        }
        self.estimates.integral(self, domain)
    }

    /// On the sphere, returns that of the function before the rotation. On the hemisphere returns
    /// estimates with their errors where exact energies would need too many values.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        if domain == Domain::Sphere {
            return self.function.energy(domain, lmax);
        }
        self.estimates.energy(self, domain, lmax)
    }

    fn feature_degree(&self) -> Option<usize> {
        self.function.feature_degree()
    }

    fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
        let [even, odd] = self.function.squared_parts(lmax)?;
        Ok([even.rotated(self.rotation)?, odd.rotated(self.rotation)?])
    }

    /// On the sphere that of the function before the rotation.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        if domain == Domain::Sphere {
            return self.function.kurtosis(domain);
        }
        quadrature::kurtosis(&self.shape().ok()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    fn energy_degree(&self, domain: Domain, lmax: usize) -> usize {
        match self.shape() {
            Ok(shape) if shape.fold(domain) == Fold::Cut => {
                quadrature::affordable_degree(&shape, domain, lmax)
            }
            _ => self.function.energy_degree(Domain::Sphere, lmax),
        }
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        self.function.energy_seconds(domain, lmax)
    }

    fn band_limit(&self) -> Option<usize> {
        self.function.band_limit()
    }

    fn resolved_degree(&self) -> Option<usize> {
        self.function.resolved_degree()
    }
}
