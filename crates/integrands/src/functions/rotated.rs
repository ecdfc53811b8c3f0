use glam::{DMat3, DQuat, DVec3};
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::closed_form::{ClosedForm, from_closed_form};
use crate::{Coefficients, Energy, Error, Integrand, Shape, quadrature};

/// An integrand after a rotation R of the sphere, `f(R^-1 x)`.
///
/// On the sphere integral and energies stay what they are. On the hemisphere they follow from these for
/// even functions and for those that vanish below the equator, and else by quadrature with the
/// equator as an edge.
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
    turn: DQuat,
    /// The same as a matrix.
    rotation: DMat3,
}

impl<I: Integrand> Rotated<I> {
    /// `function` after `rotation`, which is brought to unit length.
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if `rotation` has no direction: zero or not finite.
    pub fn new(function: I, rotation: DQuat) -> Result<Self, Error> {
        let length = rotation.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Error::Rotation { length });
        }
        let turn = rotation.normalize();
        Ok(Self { function, turn, rotation: DMat3::from_quat(turn) })
    }

    /// `function` rotated by `psi` about +z and then carried with +z to colatitude `theta` and longitude
    /// `phi`, all in radians.
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if an angle is not finite.
    pub fn to_angles(function: I, theta: f64, phi: f64, psi: f64) -> Result<Self, Error> {
        Self::new(function, turn_to_angles(theta, phi, psi))
    }

    /// This integrand after a further rotation: both are folded into one, so that chains of any length cost what one
    /// rotation does.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn then(self, rotation: DQuat) -> Result<Self, Error> {
        Self::new(self.function, rotation * self.turn)
    }

    /// This integrand after a further rotation by angles, as for [`to_angles`](Self::to_angles).
    ///
    /// # Errors
    ///
    /// [`Error::Rotation`] if an angle is not finite.
    pub fn then_to_angles(self, theta: f64, phi: f64, psi: f64) -> Result<Self, Error> {
        self.then(turn_to_angles(theta, phi, psi))
    }
}

/// The rotation by `psi` about +z that then carries +z to colatitude `theta` and longitude `phi`.
fn turn_to_angles(theta: f64, phi: f64, psi: f64) -> DQuat {
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

    /// On the sphere those of the function before the rotation.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        if domain == Domain::Sphere {
            return self.function.energy(domain, lmax);
        }
        let per_degree = self.coefficients(domain, lmax)?.energy_per_degree()?;
        Ok(Energy::new(domain, per_degree, self.centred_square(domain)?))
    }

    /// On the sphere that of the function before the rotation.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        if domain == Domain::Sphere {
            return self.function.kurtosis(domain);
        }
        quadrature::kurtosis(&self.shape().ok()?, domain, &|dir| self.eval(dir))
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
