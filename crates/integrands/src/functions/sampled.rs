use glam::DVec3;

use crate::quadrature::finite_values_at;
use crate::{Circle, Error, Integrand, Shape};

/// A user-defined function with a declared shape. Integral, coefficients and energies follow by
/// quadrature of its values.
///
/// A closure `Fn(DVec3) -> f64` is an [`Integrand`]; implement it for functions that are evaluated
/// in batches or whose evaluation can fail. A value that is NaN or infinite, or whose evaluation
/// panics, is [`Error::Evaluation`] with the direction.
///
/// The declaration is a degree: everywhere (between the edges, if any are declared) the function is
/// a polynomial of this degree in x, y and z to the required accuracy. Results are then exact to
/// rounding. The rules are exact for the degree in the integral, for twice the degree in the
/// square, and for `degree + lmax` in coefficients. For a smooth function that is not a polynomial,
/// the error of the integral consists of some of its coefficients beyond the degree, and that of
/// the square and the coefficients of products of those (aliasing). An undeclared edge causes an
/// error of about `jump/degree` in every result, and energies near the degree are meaningless.
/// Doubling the degree shows the error.
///
/// Cost: some `degree^2` values for the integral, `2 (degree + lmax)^2` for coefficients.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{Domain, Integrand, SampledFunction};
///
/// let f = SampledFunction::new(|d: DVec3| (d.x + 2.0 * d.z).exp(), 30);
/// // int e^{a . x} = 4 pi sinh(|a|)/|a|
/// let a = 5f64.sqrt();
/// let exact = 4.0 * std::f64::consts::PI * a.sinh()/a;
/// assert!((f.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-14);
/// let energy = f.energy(Domain::Sphere, 30)?;
/// let sum: f64 = energy.per_band().iter().sum();
/// assert!((sum / energy.total() - 1.0).abs() < 1e-14);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SampledFunction<F> {
    function: F,
    shape: Shape,
}

impl<F: Integrand> SampledFunction<F> {
    /// Returns the function, as smooth as a polynomial of `degree`.
    #[must_use]
    pub fn new(function: F, degree: usize) -> Self {
        Self { function, shape: Shape::smooth(degree) }
    }

    /// Returns the function with a fully specified shape: zonal, even, of narrow support.
    #[must_use]
    pub fn with_shape(function: F, shape: Shape) -> Self {
        Self { function, shape }
    }

    /// Adds a circle across which values or derivatives may jump.
    #[must_use]
    pub fn with_edge(mut self, edge: Circle) -> Self {
        self.shape = self.shape.with_edge(edge);
        self
    }
}

impl<F: Integrand> Integrand for SampledFunction<F> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.function.eval(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        finite_values_at(&self.function, dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(self.shape.clone())
    }
}
