use std::f64::consts::PI;

use glam::DVec3;
use sphvar_grammar::Parametric;
use sphvar_sh::ByParity;

use super::closed_form::{ClosedForm, from_closed_form};
use crate::definition::Definition;
use crate::{Coefficients, Error, Integrand, IntegrandResolver, PhongLobe, Shape};

/// The clamped cosine max(0, z): the irradiance kernel of a surface facing +z, continuous with a
/// kink; the [`PhongLobe`] of exponent 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClampedCosine;

impl ClampedCosine {
    pub(super) const LOBE: PhongLobe = PhongLobe { exponent: 1.0 };
}

impl ClosedForm for ClampedCosine {
    fn sphere_integral(&self) -> Option<f64> {
        Some(PI)
    }

    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        Self::LOBE.sphere_centred_square()
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        Self::LOBE.sphere_coefficients(lmax)
    }
}

impl Integrand for ClampedCosine {
    fn eval(&self, dir: DVec3) -> f64 {
        dir.z.max(0.0)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Self::LOBE.shape()
    }

    from_closed_form!();
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(ClampedCosine))
    }
}
