use sphvar_samplers::Domain;

use crate::{Error, Integrand, Shape, quadrature};

/// `int F G` over the sphere, of the even extensions on the hemisphere.
///
/// A function without edges has no coefficients beyond its degree, and the sum of the products of coefficients
/// ends there. Functions with edges are integrated ring by ring.
pub(super) fn inner_product(
    f: &dyn Integrand,
    g: &dyn Integrand,
    domain: Domain,
) -> Result<f64, Error> {
    let (a, b) = (f.shape(), g.shape());
    if let (Ok(a), Ok(b)) = (&a, &b)
        && domain == Domain::Sphere
        && a.is_apart_from(b)
    {
        return Ok(0.0);
    }
    let limit = |shape: &Result<Shape, Error>| {
        shape.as_ref().ok().filter(|s| s.is_band_limited(domain)).map(Shape::degree)
    };
    if let Some(lmax) = limit(&a).into_iter().chain(limit(&b)).min() {
        let (f, g) = (f.coefficients(domain, lmax)?, g.coefficients(domain, lmax)?);
        return Ok(f.inner_per_degree(&g)?.iter().sum());
    }
    let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
    let product = a?.product(&b?);
    Ok(copies * quadrature::integral(&product, domain, &|dir| f.eval(dir) * g.eval(dir))?)
}
