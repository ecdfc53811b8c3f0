use std::fmt;

use glam::DVec3;
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::sum_square::{self, sum_of_coefficients, weighted_sum_into};
use crate::quadrature::{self, Estimates};
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// A weighted sum of integrands, `sum_i w_i f_i`.
///
/// Integral and coefficients are sums. The square is computed from the coefficients of all terms
/// without edges, quadratures of all terms about one axis, and inner products of the remaining
/// terms. The time is proportional to the number of terms unless each has edges about a different
/// axis.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Cap, ClampedCosine, Domain, Integrand, Sum};
///
/// let sum = Sum::default().plus(1.0, ClampedCosine)?.plus(-0.5, Cap::half_space(0.0)?)?;
/// assert!(sum.exact(Domain::Hemisphere).unwrap().abs() < 1e-15);
/// // 2 int_0^1 (z - 1/2)^2 2 pi dz
/// let square = sum.square(Domain::Hemisphere)?;
/// assert!((square - std::f64::consts::PI / 3.0).abs() < 1e-14);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Default)]
pub struct Sum {
    terms: Vec<(f64, Box<dyn Integrand>)>,
    estimates: Estimates,
}

impl Sum {
    /// The smallest magnitude of a weight that is not 0.
    pub const MIN_WEIGHT: f64 = 1e-150;
    /// The largest magnitude of a weight.
    pub const MAX_WEIGHT: f64 = 1e150;

    /// Returns this sum with a further term.
    ///
    /// # Errors
    ///
    /// [`Error::Weight`] unless the weight is 0 or [`MIN_WEIGHT`](Self::MIN_WEIGHT) to
    /// [`MAX_WEIGHT`](Self::MAX_WEIGHT) in magnitude, so that squares of integrals neither overflow
    /// nor underflow.
    pub fn plus(mut self, weight: f64, term: impl Integrand + 'static) -> Result<Self, Error> {
        Self::check_weight(weight)?;
        self.terms.push((weight, Box::new(term)));
        Ok(self)
    }

    /// Checks that a weight is in the range of [`plus`](Self::plus).
    pub(crate) fn check_weight(weight: f64) -> Result<(), Error> {
        if weight != 0.0 && !(Self::MIN_WEIGHT..=Self::MAX_WEIGHT).contains(&weight.abs()) {
            return Err(Error::Weight { got: weight });
        }
        Ok(())
    }

    fn terms(&self) -> impl Iterator<Item = (f64, &dyn Integrand)> {
        self.terms.iter().map(|(w, f)| (*w, &**f))
    }

    /// Returns the shape of the sum if several of its terms are products of functions about different
    /// axes, whose coefficients would have to be rotated.
    fn joint_shape(&self) -> Option<Shape> {
        /// Sums of more edges or of expensive terms take longer than rotations.
        const MAX_EDGES: usize = 16;
        const MAX_COST: f64 = 32.0;
        let is_general = |(weight, f): &&(f64, Box<dyn Integrand>)| {
            let is_zonal = |shape: &Shape| shape.axis().is_some();
            *weight != 0.0 && !f.shape().is_ok_and(|shape| is_zonal(&shape))
        };
        if self.terms.iter().filter(is_general).count() < 2 {
            return None;
        }
        let shape = self.shape().ok()?;
        let is_simple = shape.edges().len() <= MAX_EDGES && shape.cost() <= MAX_COST;
        (is_simple && !shape.edges().is_empty()).then_some(shape)
    }

    /// Returns the maximum of a quantity over the terms, if all terms have it.
    fn largest(&self, of: impl Fn(&dyn Integrand) -> Option<usize>) -> Option<usize> {
        let each: Option<Vec<usize>> = self.terms.iter().map(|(_, f)| of(&**f)).collect();
        each?.into_iter().max()
    }
}

impl fmt::Debug for Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.terms.iter().map(|(weight, _)| weight)).finish()
    }
}

impl Integrand for Sum {
    fn eval(&self, dir: DVec3) -> f64 {
        self.terms.iter().map(|(w, f)| w * f.eval(dir)).sum()
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        weighted_sum_into(self.terms(), dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        let mut shapes = self.terms.iter().map(|(_, f)| f.shape());
        let first = shapes.next().unwrap_or_else(|| Ok(Shape::smooth(0)))?;
        shapes.try_fold(first, |sum, shape| Ok(sum.sum(&shape?)))
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        self.terms.iter().map(|(w, f)| Some(w * f.exact(domain)?)).sum()
    }

    /// Returns the sums of those of the terms, or of the values if several terms have them in frames
    /// of their own.
    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        match self.joint_shape() {
            Some(shape) => quadrature::coefficients(&shape, domain, lmax, &|dirs, values| {
                self.eval_into(dirs, values)
            }),
            None => sum_of_coefficients(self.terms(), domain, lmax),
        }
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        sum_square::centred_square(self.terms(), domain)
    }

    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        match &self.terms[..] {
            [(weight, only)] => {
                let (integral, error) = only.integral_estimate(domain)?;
                Some((weight * integral, weight.abs() * error))
            }
            _ => self.estimates.integral(self, domain),
        }
    }

    /// Returns that of a single term with its errors. Estimates of several terms cannot be combined,
    /// since they do not determine the errors of inner products: the sum is estimated as a whole.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let exact = quadrature::exact_energy(self, domain, lmax);
        match (&exact, &self.terms[..]) {
            (Err(Error::NoEnergy { .. }), [(weight, only)]) if *weight != 0.0 => {
                Ok(only.energy(domain, lmax)?.of_multiple(*weight))
            }
            _ => self.estimates.unless_exact(exact, self, domain, lmax),
        }
    }

    fn feature_degree(&self) -> Option<usize> {
        self.largest(|f| f.feature_degree())
    }

    /// Returns that of a single term, otherwise that of the values.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        // The values of longer sums take too long.
        const MAX_TERMS: usize = 16;
        match &self.terms[..] {
            [(weight, only)] => only.kurtosis(domain).filter(|_| *weight != 0.0),
            terms if terms.len() <= MAX_TERMS => quadrature::kurtosis_of_values(
                self.shape().ok().as_ref(),
                domain,
                &|dirs, values| self.eval_into(dirs, values),
            ),
            _ => None,
        }
    }

    fn energy_degree(&self, domain: Domain, lmax: usize) -> usize {
        if let Some(shape) = self.joint_shape() {
            return quadrature::affordable_degree(&shape, domain, lmax);
        }
        self.terms.iter().map(|(_, f)| f.energy_degree(domain, lmax)).min().unwrap_or(lmax)
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        self.terms.iter().map(|(_, f)| f.energy_seconds(domain, lmax)).sum()
    }

    fn band_limit(&self) -> Option<usize> {
        self.largest(|f| f.band_limit())
    }

    fn resolved_degree(&self) -> Option<usize> {
        self.largest(|f| f.resolved_degree().or(f.band_limit()))
    }
}
