use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::Frequencies;

use super::SquareDefinition;
use super::disk::{check_centre, declare_centre};
use super::panel_series::{Offset, PanelSeries};
use super::separable::Separable;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// A Gaussian peak of height 1 in the square, `exp(-((u - u0)^2 + (v - v0)^2)/(2 width^2))`.
///
/// It ends at the sides and is not continued at the opposite ones. A narrow peak has the energies of
/// a smooth periodic function, a wide one those of jumps across the sides. The energies follow from
/// Legendre series on intervals of at most 8 widths.
#[derive(Clone, Debug)]
pub struct Gaussian {
    width: f64,
    centre: [f64; 2],
    separable: Separable,
}

impl Gaussian {
    /// The smallest and the largest width.
    pub const WIDTHS: [f64; 2] = [1e-9, 1e9];

    /// The number of widths beyond which the peak is below rounding.
    const SUPPORT: f64 = 9.0;

    /// Returns the peak of a width (standard deviation) from 1e-9 to 1e9 about a centre in [0, 1]^2.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the ranges.
    pub fn new(width: f64, centre: [f64; 2]) -> Result<Self, Error> {
        let [min, max] = Self::WIDTHS;
        if !(min..=max).contains(&width) {
            return Err(Error::Parameter { name: "width", range: "in [1e-9, 1e9]", got: width });
        }
        check_centre(centre)?;
        let along = |centre: f64| {
            // Wide peaks are nearly 1.
            let constant = if width > 1.0 { 1.0 } else { 0.0 };
            // A peak may be narrow beside the rounding of coordinates.
            let deviation = |middle: f64, offset: f64| {
                let exponent = -0.5 * (((middle - centre) + offset) / width).powi(2);
                if width > 1.0 { exponent.exp_m1() } else { exponent.exp() }
            };
            PanelSeries::new(&[Offset { constant, deviation: &deviation }], |a, b| {
                let distance = (a - centre).max(centre - b);
                distance > Self::SUPPORT * width || b - a <= 8.0 * width
            })
        };
        let separable = Separable::new(along(centre[0])?, along(centre[1])?);
        Ok(Self { width, centre, separable })
    }
}

impl SquareIntegrand for Gaussian {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let [x, y] = [u - self.centre[0], v - self.centre[1]].map(|x| x / self.width);
        (-0.5 * (x * x + y * y)).exp()
    }

    fn exact(&self) -> Option<f64> {
        Some(self.separable.mean())
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        self.separable.energy(frequencies)
    }

    fn feature_size(&self) -> Option<f64> {
        Some(self.width.min(1.0))
    }

    fn kurtosis(&self) -> Option<f64> {
        self.separable.kurtosis()
    }

    /// The peak is a product g(u) g(v), so with the variations V of both factors the variation is
    /// `V_u V_v + V_u g(1) + g(1) V_v`.
    fn variation(&self) -> Option<f64> {
        let drop = |x: f64| -(-0.5 * (x / self.width).powi(2)).exp_m1();
        let [u, v] = self.centre.map(|c| {
            let (before, after) = (drop(c), drop(1.0 - c));
            (before + after, 1.0 - after)
        });
        Some(u.0 * v.0 + u.0 * v.1 + u.1 * v.0)
    }
}

/// Parameters of a [`Gaussian`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianParameters {
    /// The standard deviation.
    pub width: f64,
    /// The first coordinate of the centre.
    pub u: f64,
    /// The second coordinate of the centre.
    pub v: f64,
}

/// An example.
impl Default for GaussianParameters {
    fn default() -> Self {
        Self { width: 0.1, u: 0.5, v: 0.5 }
    }
}

impl Parametric for GaussianParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let [min, max] = Gaussian::WIDTHS;
        d.required_number("width", Range::closed(min, max), "standard deviation", &mut self.width);
        declare_centre(d, [&mut self.u, &mut self.v]);
    }
}

impl SquareDefinition for GaussianParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(Gaussian::new(self.width, [self.u, self.v])?))
    }
}
