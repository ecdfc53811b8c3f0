use std::f64::consts::{PI, TAU};

use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::{ByAxis, Frequencies};

use super::SquareDefinition;
use super::energy::energy_of_coefficients;
use crate::functions::cap::two_valued_kurtosis;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// The indicator of a disk on the torus: of the points within a radius of a centre, where opposite
/// sides of the square are joined. A disk that crosses a side continues at the opposite one.
///
/// `|G_k|^2 = (r J_1(2 pi r |k|)/|k|)^2` whatever the centre, so the variance over random toroidal
/// shifts does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    radius: f64,
    centre: [f64; 2],
}

impl Disk {
    /// The smallest and the largest radius; larger disks overlap themselves.
    pub const RADII: [f64; 2] = [1e-9, 0.5];

    /// Returns the disk of a radius from 1e-9 to 0.5 about a centre in [0, 1]^2.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the ranges.
    pub fn new(radius: f64, centre: [f64; 2]) -> Result<Self, Error> {
        let [min, max] = Self::RADII;
        if !(min..=max).contains(&radius) {
            return Err(Error::Parameter { name: "radius", range: "in [1e-9, 0.5]", got: radius });
        }
        check_centre(centre)?;
        Ok(Self { radius, centre })
    }

    fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }
}

/// Checks that a centre is in the square.
pub(super) fn check_centre(centre: [f64; 2]) -> Result<(), Error> {
    for (name, got) in [("u", centre[0]), ("v", centre[1])] {
        if !(0.0..=1.0).contains(&got) {
            return Err(Error::Parameter { name, range: "in [0, 1]", got });
        }
    }
    Ok(())
}

impl SquareIntegrand for Disk {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let around = |x: f64, c: f64| (x - c) - (x - c).round();
        let distance = around(u, self.centre[0]).hypot(around(v, self.centre[1]));
        f64::from(u8::from(distance <= self.radius))
    }

    fn exact(&self) -> Option<f64> {
        Some(self.area())
    }

    /// The total variance is A (1 - A), and that of the lengths of the chords along either axis
    /// `16 r^3/3 - A^2`.
    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let r = self.radius;
        let axis = r.powi(3) * (16.0 / 3.0 - PI * PI * r);
        let off = r * r * (PI - 32.0 / 3.0 * r + (PI * r).powi(2));
        let centred = ByAxis { off, u: axis, v: axis };
        energy_of_coefficients(frequencies, self.area(), centred, |[k1, k2]| {
            let k = f64::from(k1).hypot(f64::from(k2));
            (r * libm::j1(TAU * r * k) / k).powi(2)
        })
    }

    fn feature_size(&self) -> Option<f64> {
        Some(self.radius)
    }

    fn kurtosis(&self) -> Option<f64> {
        let area = self.area();
        two_valued_kurtosis(area, 1.0 - area)
    }
}

/// Parameters of a [`Disk`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskParameters {
    /// The radius.
    pub radius: f64,
    /// The first coordinate of the centre.
    pub u: f64,
    /// The second coordinate of the centre.
    pub v: f64,
}

/// An example.
impl Default for DiskParameters {
    fn default() -> Self {
        Self { radius: 0.25, u: 0.5, v: 0.5 }
    }
}

impl Parametric for DiskParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let [min, max] = Disk::RADII;
        d.required_number("radius", Range::closed(min, max), "radius", &mut self.radius);
        declare_centre(d, [&mut self.u, &mut self.v]);
    }
}

/// Declares the coordinates of a centre.
pub(super) fn declare_centre(d: &mut Declaration<'_>, [u, v]: [&mut f64; 2]) {
    d.number("u", Range::closed(0.0, 1.0), "first coordinate of the centre", u);
    d.number("v", Range::closed(0.0, 1.0), "second coordinate of the centre", v);
}

impl SquareDefinition for DiskParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(Disk::new(self.radius, [self.u, self.v])?))
    }
}
