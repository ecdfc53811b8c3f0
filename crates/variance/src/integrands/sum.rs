use std::fmt;

use glam::DVec3;
use sphvar_samplers::Domain;

use super::inner_product::inner_product;
use crate::{Coefficients, Error, Integrand, Shape};

/// A weighted sum of integrands, `sum_i w_i f_i`.
///
/// Integral and coefficients are sums; the square has the cross terms
/// `2 w_i w_j int F_i F_j`, inner products of coefficients where one of the two has no edges, and quadrature
/// over rings split at both functions' edges else.
///
/// # Examples
///
/// ```
/// use sphvar_variance::{Cap, ClampedCosine, Domain, Integrand, Sum};
///
/// let sum = Sum::default().plus(1.0, ClampedCosine)?.plus(-0.5, Cap::half_space(0.0)?)?;
/// assert!(sum.exact(Domain::Hemisphere).unwrap().abs() < 1e-15);
/// // 2 int_0^1 (z - 1/2)^2 2 pi dz
/// let square = sum.square(Domain::Hemisphere)?;
/// assert!((square - std::f64::consts::PI / 3.0).abs() < 1e-14);
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Default)]
pub struct Sum {
    terms: Vec<(f64, Box<dyn Integrand>)>,
}

impl Sum {
    /// This sum with a further term.
    ///
    /// # Errors
    ///
    /// [`Error::Weight`] if the weight is not finite.
    pub fn plus(mut self, weight: f64, term: impl Integrand + 'static) -> Result<Self, Error> {
        if !weight.is_finite() {
            return Err(Error::Weight { got: weight });
        }
        self.terms.push((weight, Box::new(term)));
        Ok(self)
    }

    /// The largest of a number that all terms have.
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

    fn shape(&self) -> Result<Shape, Error> {
        let mut shapes = self.terms.iter().map(|(_, f)| f.shape());
        let first = shapes.next().unwrap_or_else(|| Ok(Shape::smooth(0)))?;
        shapes.try_fold(first, |sum, shape| Ok(sum.sum(&shape?)))
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        self.terms.iter().map(|(w, f)| Some(w * f.exact(domain)?)).sum()
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        let mut sum = Coefficients::zonal(DVec3::Z, vec![0.0; lmax + 1])?;
        for (weight, f) in &self.terms {
            sum = sum.plus(*weight, &f.coefficients(domain, lmax)?)?;
        }
        Ok(sum)
    }

    fn square(&self, domain: Domain) -> Result<f64, Error> {
        let mut sum = 0.0;
        for (i, (v, f)) in self.terms.iter().enumerate() {
            sum += v * v * f.square(domain)?;
            for (w, g) in &self.terms[..i] {
                sum += 2.0 * v * w * inner_product(&**f, &**g, domain)?;
            }
        }
        // Terms that cancel leave rounding of either sign.
        Ok(sum.max(0.0))
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
