use std::f64::consts::PI;

use glam::DVec3;
use sphvar_grammar::Parametric;
use sphvar_sh::ByParity;

use super::closed_form::{ClosedForm, from_closed_form};
use crate::definition::Definition;
use crate::{ClampedCosine, Coefficients, Error, Integrand, IntegrandResolver, Shape};

/// The absolute cosine `|z|`, or `|x . d|` about another axis d: the even extension of the cosine.
///
/// It is an even function and equals twice the clamped cosine in even degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AbsCosine;

impl ClosedForm for AbsCosine {
    fn sphere_integral(&self) -> Option<f64> {
        Some(2.0 * PI)
    }

    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        Ok(ByParity { even: 4.0 * ClampedCosine::LOBE.sphere_centred_square()?.even, odd: 0.0 })
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        Ok(ClampedCosine::LOBE.sphere_coefficients(lmax)?.even_extension())
    }
}

impl Integrand for AbsCosine {
    fn eval(&self, dir: DVec3) -> f64 {
        dir.z.abs()
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(ClampedCosine::LOBE.edges().even())
    }

    from_closed_form!();
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(AbsCosine))
    }
}
