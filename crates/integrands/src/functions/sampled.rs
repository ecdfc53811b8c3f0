use glam::DVec3;

use crate::{Circle, Error, Integrand, Shape};

/// A function of the caller's with a statement of its shape, from which integral, coefficients and energies
/// follow by quadrature of its values.
///
/// The statement is a degree: everywhere (between the edges, if some are stated) the function is a
/// polynomial of this degree in x, y and z to the accuracy that is wanted. Then all is exact to rounding. The rules
/// are exact for the degree in the integral, for twice the degree in the square, and for `degree + lmax` in
/// coefficients. Of a smooth function that is no polynomial the integral is wrong by some of its coefficients
/// beyond the degree, and the square and the coefficients by products of those, as with any sampling
/// (aliasing). Across an edge that was not stated every result is wrong by about `jump/degree`, and energies near the
/// degree mean nothing. Doubling the degree shows the error.
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

impl<F: Fn(DVec3) -> f64 + Sync> SampledFunction<F> {
    /// The function, smooth as a polynomial of `degree`.
    #[must_use]
    pub fn new(function: F, degree: usize) -> Self {
        Self { function, shape: Shape::smooth(degree) }
    }

    /// The function with a shape in all detail: zonal, even, of narrow support.
    #[must_use]
    pub fn with_shape(function: F, shape: Shape) -> Self {
        Self { function, shape }
    }

    /// With a circle across which values or derivatives may jump.
    #[must_use]
    pub fn with_edge(mut self, edge: Circle) -> Self {
        self.shape = self.shape.with_edge(edge);
        self
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> Integrand for SampledFunction<F> {
    fn eval(&self, dir: DVec3) -> f64 {
        (self.function)(dir)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(self.shape.clone())
    }
}
