use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::Frequencies;

use super::SquareDefinition;
use super::panel_series::{Offset, PanelSeries};
use super::separable::Separable;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// The function `exp(a u + b v)`: smooth and monotonic in the square, with jumps across the sides of
/// its periodic extension. Most of its energy at high frequencies is on the axes.
#[derive(Clone, Debug)]
pub struct Exponential {
    rates: [f64; 2],
    separable: Separable,
}

impl Exponential {
    /// The largest magnitude of both rates.
    pub const MAX_RATE: f64 = 100.0;

    /// Returns the function with the rates `[a, b]`, from -100 to 100.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(rates: [f64; 2]) -> Result<Self, Error> {
        for (name, got) in [("a", rates[0]), ("b", rates[1])] {
            if !(-Self::MAX_RATE..=Self::MAX_RATE).contains(&got) {
                return Err(Error::Parameter { name, range: "in [-100, 100]", got });
            }
        }
        let along = |rate: f64| {
            let deviation = |middle: f64, offset: f64| (rate * (middle + offset)).exp_m1();
            PanelSeries::new(&[Offset { constant: 1.0, deviation: &deviation }], |a, b| {
                (b - a) * rate.abs() <= 16.0
            })
        };
        let separable = Separable::new(along(rates[0])?, along(rates[1])?);
        Ok(Self { rates, separable })
    }
}

impl SquareIntegrand for Exponential {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        (self.rates[0] * u + self.rates[1] * v).exp()
    }

    fn exact(&self) -> Option<f64> {
        Some(self.separable.mean())
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        self.separable.energy(frequencies)
    }

    fn feature_size(&self) -> Option<f64> {
        Some(self.rates.iter().fold(1.0, |size, rate| f64::min(size, rate.abs().recip())))
    }

    fn kurtosis(&self) -> Option<f64> {
        self.separable.kurtosis()
    }

    /// Returns 0 for the constant.
    fn band_limit(&self) -> Option<usize> {
        self.rates.iter().all(|rate| *rate == 0.0).then_some(0)
    }

    /// Returns that of the product of two monotonic functions.
    fn variation(&self) -> Option<f64> {
        let [u, v] = self.rates.map(|rate| (rate.exp_m1().abs(), rate.exp()));
        Some(u.0 * v.0 + u.0 * v.1 + u.1 * v.0)
    }
}

/// Parameters of an [`Exponential`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialParameters {
    /// The rate along u.
    pub a: f64,
    /// The rate along v.
    pub b: f64,
}

/// An example.
impl Default for ExponentialParameters {
    fn default() -> Self {
        Self { a: 1.0, b: 2.0 }
    }
}

impl Parametric for ExponentialParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::closed(-Exponential::MAX_RATE, Exponential::MAX_RATE);
        d.required_number("a", range, "rate along u", &mut self.a);
        d.required_number("b", range, "rate along v", &mut self.b);
    }
}

impl SquareDefinition for ExponentialParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(Exponential::new([self.a, self.b])?))
    }
}
