use glam::DVec3;
use sphvar_sh::{ByParity, Domain, LegendrePlan};

use super::closed_form::{ClosedForm, from_closed_form};
use crate::shape::colatitude_between;
use crate::{Coefficients, Error, Integrand, Shape, quadrature};

/// A band-limited function of the angle from an axis, `sum_l c_l Y_l0(angle)`.
///
/// A value takes as many steps as there are degrees.
#[derive(Clone, Debug)]
pub(super) struct ZonalSeries {
    axis: DVec3,
    per_degree: Vec<f64>,
    legendre: LegendrePlan,
}

impl ZonalSeries {
    /// Returns the function of coefficients from degree 0.
    pub(super) fn new(axis: DVec3, per_degree: Vec<f64>) -> Result<Self, Error> {
        let legendre = LegendrePlan::new(per_degree.len() - 1)?;
        Ok(Self { axis, per_degree, legendre })
    }

    fn value(&self, dir: DVec3, column: &mut [f64]) -> f64 {
        self.legendre.column_into(0, colatitude_between(self.axis, dir), column);
        self.per_degree.iter().zip(&*column).map(|(c, y)| c * y).sum()
    }
}

impl ClosedForm for ZonalSeries {
    fn sphere_integral(&self) -> Option<f64> {
        Some(self.per_degree[0] * Domain::Sphere.area().sqrt())
    }

    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        let mut sums = ByParity::both(0.0);
        for (l, c) in self.per_degree.iter().enumerate().skip(1) {
            *sums.of_mut(l) += c * c;
        }
        Ok(sums)
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let mut per_degree = self.per_degree.clone();
        per_degree.resize(lmax + 1, 0.0);
        Coefficients::zonal(self.axis, per_degree)
    }
}

impl Integrand for ZonalSeries {
    fn eval(&self, dir: DVec3) -> f64 {
        self.value(dir, &mut vec![0.0; self.per_degree.len()])
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let mut column = vec![0.0; self.per_degree.len()];
        for (value, &dir) in values.iter_mut().zip(dirs) {
            *value = self.value(dir, &mut column);
        }
        Ok(())
    }

    fn shape(&self) -> Result<Shape, Error> {
        let lmax = self.per_degree.len() - 1;
        // As a harmonic: the recurrence takes a step a degree.
        let shape = Shape::smooth(lmax).zonal(self.axis).with_cost(1.0 + lmax as f64 / 8.0);
        let is_even = self.per_degree.iter().skip(1).step_by(2).all(|c| *c == 0.0);
        Ok(if is_even { shape.even() } else { shape })
    }

    from_closed_form!();

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        // Values at four times the degree, each of as many steps.
        const MAX_DEGREE: usize = 2048;
        let shape = self.shape().ok().filter(|shape| shape.degree() <= MAX_DEGREE)?;
        quadrature::kurtosis(&shape, domain, &|dirs, values| self.eval_into(dirs, values))
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.per_degree.len() - 1)
    }
}
