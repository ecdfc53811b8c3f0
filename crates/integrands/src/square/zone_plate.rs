use std::f64::consts::PI;

use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::Frequencies;

use super::SquareDefinition;
use super::panel_series::{Offset, PanelSeries};
use super::separable::Separable;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// The zone plate `sin(x^2 + y^2)` with x = scale u and y = scale v (Singh 2015, Figures 4.1 and
/// 4.8): the frequency along u grows to scale^2/pi periods per unit at u = 1, and so passes that of
/// any pattern, where regular patterns have artifacts and random ones noise.
///
/// `sin(x^2 + y^2) = sin x^2 cos y^2 + cos x^2 sin y^2` has the coefficients of two products of
/// Fresnel integrals; these follow from Legendre series on intervals of at most 28 radians.
#[derive(Clone, Debug)]
pub struct ZonePlate {
    scale: f64,
    separable: Separable,
}

impl ZonePlate {
    /// The smallest and the largest scale.
    pub const SCALES: [f64; 2] = [1e-9, 100.0];

    /// Returns the zone plate of a scale from 1e-9 to 100.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(scale: f64) -> Result<Self, Error> {
        let [min, max] = Self::SCALES;
        if !(min..=max).contains(&scale) {
            return Err(Error::Parameter { name: "scale", range: "in [1e-9, 100]", got: scale });
        }
        let square = |x: f64| (scale * x).powi(2);
        let sin = |middle: f64, offset: f64| square(middle + offset).sin();
        // cos t = 1 - 2 sin^2(t/2).
        let cosine_minus_1 =
            |middle: f64, offset: f64| -2.0 * (0.5 * square(middle + offset)).sin().powi(2);
        let sine = || Offset { constant: 0.0, deviation: &sin };
        let cosine = || Offset { constant: 1.0, deviation: &cosine_minus_1 };
        let is_resolved = |a: f64, b: f64| square(b) - square(a) <= 28.0;
        let u = PanelSeries::new(&[sine(), cosine()], is_resolved)?;
        let v = PanelSeries::new(&[cosine(), sine()], is_resolved)?;
        Ok(Self { scale, separable: Separable::new(u, v) })
    }
}

impl SquareIntegrand for ZonePlate {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let [x, y] = [u, v].map(|x| self.scale * x);
        (x * x + y * y).sin()
    }

    fn exact(&self) -> Option<f64> {
        Some(self.separable.mean())
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        self.separable.energy(frequencies)
    }

    /// Returns half of the shortest period, at the far sides.
    fn feature_size(&self) -> Option<f64> {
        Some((0.5 * PI / (self.scale * self.scale)).min(1.0))
    }

    fn kurtosis(&self) -> Option<f64> {
        self.separable.kurtosis()
    }
}

/// Parameters of a [`ZonePlate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZonePlateParameters {
    /// The side of the square in units of x and y.
    pub scale: f64,
}

/// The scale at which the frequency at the far sides is that of a grid of 127 points along a side.
impl Default for ZonePlateParameters {
    fn default() -> Self {
        Self { scale: 20.0 }
    }
}

impl Parametric for ZonePlateParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let [min, max] = ZonePlate::SCALES;
        let summary =
            "side of the square in x and y; at u = 1 there are scale^2/pi periods per unit";
        d.number("scale", Range::closed(min, max), summary, &mut self.scale);
    }
}

impl SquareDefinition for ZonePlateParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(ZonePlate::new(self.scale)?))
    }
}
