use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::Cap;
use super::closed_form::{ClosedForm, from_closed_form};
use crate::definition::Definition;
use crate::{Circle, Coefficients, Error, Integrand, IntegrandResolver, Shape};

/// The indicator of the two caps within an angle of +z and of -z, `|z| >= cos(angle)`: the cap of
/// antipodal (projective) sets, an even function.
///
/// Its coefficients are twice those of the [`Cap`] in even degrees and 0 in odd ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleCap {
    cap: Cap,
}

impl DoubleCap {
    /// Returns the two caps of `angle` radians, in (0, pi/2].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(angle: f64) -> Result<Self, Error> {
        if !(angle > 0.0 && angle <= FRAC_PI_2) {
            return Err(Error::Parameter {
                name: "angle",
                range: "in (0, pi/2] radians",
                got: angle,
            });
        }
        Ok(Self { cap: Cap::new(angle)? })
    }

    /// Returns the two caps of `degrees`, in (0, 90].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn from_degrees(degrees: f64) -> Result<Self, Error> {
        if !(degrees > 0.0 && degrees <= 90.0) {
            return Err(Error::Parameter { name: "degrees", range: "in (0, 90]", got: degrees });
        }
        Ok(Self { cap: Cap::from_degrees(degrees)? })
    }
}

impl ClosedForm for DoubleCap {
    fn sphere_integral(&self) -> Option<f64> {
        Some(2.0 * self.cap.sphere_integral()?)
    }

    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        Ok(ByParity { even: 4.0 * self.cap.sphere_centred_square()?.even, odd: 0.0 })
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        Ok(self.cap.sphere_coefficients(lmax)?.even_extension())
    }
}

impl Integrand for DoubleCap {
    fn eval(&self, dir: DVec3) -> f64 {
        self.cap.eval(DVec3::new(dir.x, dir.y, dir.z.abs()))
    }

    fn shape(&self) -> Result<Shape, Error> {
        let edge = |axis| Circle { axis, angle: self.cap.angle() };
        let shape = Shape::smooth(0).zonal(DVec3::Z).even();
        Ok(shape.with_edge(edge(DVec3::Z)).with_edge(edge(DVec3::NEG_Z)))
    }

    from_closed_form!();

    /// Returns the two caps cover the same fraction of the sphere as one does of the hemisphere.
    fn kurtosis(&self, _domain: Domain) -> Option<f64> {
        self.cap.kurtosis(Domain::Hemisphere)
    }
}

/// Parameters of a [`DoubleCap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleCapParameters {
    /// The angle from +z and from -z, see [`DoubleCap::from_degrees`].
    pub degrees: f64,
}

/// An example.
impl Default for DoubleCapParameters {
    fn default() -> Self {
        Self { degrees: 60.0 }
    }
}

impl Parametric for DoubleCapParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::left_open(0.0, 90.0);
        d.required_number("degrees", range, "angle from +z and -z", &mut self.degrees);
    }
}

impl Definition for DoubleCapParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(DoubleCap::from_degrees(self.degrees)?))
    }
}
