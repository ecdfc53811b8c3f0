use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::ByParity;

use super::closed_form::{ClosedForm, from_closed_form};
use super::{exponential_degree, exponential_support};
use crate::definition::Definition;
use crate::{Circle, Coefficients, Error, Integrand, IntegrandResolver, Shape};

/// The Phong lobe `max(0, z)^n` for a real exponent n >= 0, with peak 1, not normalised: its
/// integral is `2 pi/(n + 1)`.
///
/// n = 0 is the half space z >= 0, n = 1 the clamped cosine.
/// `F_l0 = sqrt(pi (2l+1)) J_l` with the moments `J_l = int_0^1 t^n P_l(t) dt`,
///
/// ```text
/// J_0 = 1/(n+1),   J_1 = 1/(n+2),   J_l = J_{l-2} (n - l + 2)/(n + l + 1)
/// ```
///
/// (DLMF 18.17.36), which are products without cancellation. On the hemisphere the even extension
/// is `|z|^n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    pub(super) exponent: f64,
}

/// Exponents from which the edge of the lobe at the equator is negligible.
const SMOOTH_START: f64 = 20.0;

impl PhongLobe {
    /// The largest exponent, a lobe of some 0.06 degrees.
    pub const MAX_EXPONENT: f64 = 1e6;

    /// Returns the lobe of `exponent` in [0, 10^6].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(exponent: f64) -> Result<Self, Error> {
        if !(0.0..=Self::MAX_EXPONENT).contains(&exponent) {
            return Err(Error::Parameter { name: "n", range: "in [0, 1e6]", got: exponent });
        }
        Ok(Self { exponent })
    }

    /// Returns a bound on the degree of `t^n` on [0, 1], to rounding.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the exponent is in [0, 1e6]"
    )]
    fn degree(self) -> usize {
        (self.exponent.ceil() as usize).min(exponential_degree(self.exponent))
    }

    /// Returns the shape of `|t|^n`, without the kind of symmetry.
    pub(super) fn edges(self) -> Shape {
        let shape = Shape::smooth(self.degree()).zonal(DVec3::Z);
        let whole = self.exponent.fract() == 0.0;
        let shape = shape.with_edge(Circle::EQUATOR);
        if whole || self.exponent > SMOOTH_START { shape } else { shape.with_fractional_edges() }
    }

    fn value(self, z: f64) -> f64 {
        if z < 0.0 { 0.0 } else { z.powf(self.exponent) }
    }
}

impl ClosedForm for PhongLobe {
    fn sphere_integral(&self) -> Option<f64> {
        Some(2.0 * PI / (self.exponent + 1.0))
    }

    /// Returns the two parts are `|z|^n/2` and `sign(z) |z|^n/2`: `pi/(2n+1)` each, minus
    /// `pi/(n+1)^2` for the mean.
    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        let n = self.exponent;
        let odd = PI / (2.0 * n + 1.0);
        Ok(ByParity { even: odd * (n / (n + 1.0)).powi(2), odd })
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let n = self.exponent;
        let mut per_degree = vec![0.0; lmax + 1];
        let mut moments = [1.0 / (n + 1.0), 1.0 / (n + 2.0)];
        for (l, c) in per_degree.iter_mut().enumerate() {
            let x = l as f64;
            let moment = &mut moments[l % 2];
            if l >= 2 {
                *moment *= (n - (x - 2.0)) / (n + x + 1.0);
            }
            *c = (PI * (2.0 * x + 1.0)).sqrt() * *moment;
        }
        Coefficients::zonal(DVec3::Z, per_degree)
    }
}

impl Integrand for PhongLobe {
    fn eval(&self, dir: DVec3) -> f64 {
        self.value(dir.z)
    }

    fn shape(&self) -> Result<Shape, Error> {
        // z^n < e^{-n (1 - z)}.
        let angle = exponential_support(self.exponent).min(FRAC_PI_2);
        Ok(self.edges().within(Circle { axis: DVec3::Z, angle }))
    }

    from_closed_form!();
}

/// Parameters of a [`PhongLobe`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongParameters {
    /// The exponent.
    pub n: f64,
}

/// An example.
impl Default for PhongParameters {
    fn default() -> Self {
        Self { n: 20.0 }
    }
}

impl Parametric for PhongParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::closed(0.0, PhongLobe::MAX_EXPONENT);
        d.required_number("n", range, "exponent", &mut self.n);
    }
}

impl Definition for PhongParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(PhongLobe::new(self.n)?))
    }
}
