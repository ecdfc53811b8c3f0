use sphvar_grammar::{Declaration, Parametric, Range};

use crate::definition::Definition;
use crate::{Cap, Error, Integrand, IntegrandResolver};

/// Parameters of the half space of [`Cap::half_space`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpaceParameters {
    /// The height of the bounding plane.
    pub height: f64,
}

/// An example.
impl Default for HalfSpaceParameters {
    fn default() -> Self {
        Self { height: 0.0 }
    }
}

impl Parametric for HalfSpaceParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.number("height", Range::right_open(-1.0, 1.0), "height of the plane", &mut self.height);
    }
}

impl Definition for HalfSpaceParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(Cap::half_space(self.height)?))
    }
}
