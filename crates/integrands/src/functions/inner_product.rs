use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use super::lens;
use crate::{Error, Integrand, Shape, quadrature};

/// `int F G` over the sphere, of the even extensions on the hemisphere.
///
/// A function without edges has no coefficients beyond its degree, so the sum of products of
/// coefficients is finite. Functions with edges are integrated ring by ring.
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
    let values = |dirs: &[DVec3], values: &mut [f64]| product_into((f, dirs), (g, dirs), values);
    Ok(copies * quadrature::integral(&product, domain, &values)?)
}

/// Writes the products of the values of two functions, each at directions of its own.
pub(super) fn product_into(
    (f, dirs): (&dyn Integrand, &[DVec3]),
    (g, dirs_of_g): (&dyn Integrand, &[DVec3]),
    values: &mut [f64],
) -> Result<(), Error> {
    f.eval_into(dirs, values)?;
    let mut second = vec![0.0; values.len()];
    g.eval_into(dirs_of_g, &mut second)?;
    values.iter_mut().zip(&second).for_each(|(value, second)| *value *= second);
    Ok(())
}

/// `int (F - mean F)(G - mean G)` over the sphere of the even and of the odd parts of two functions
/// with edges.
///
/// The rounding error is that of the products of the functions, even where a part vanishes.
pub(super) fn centred_inner_product(
    f: &dyn Integrand,
    g: &dyn Integrand,
    domain: Domain,
) -> Result<ByParity, Error> {
    let (a, b) = (f.shape()?, g.shape()?);
    let unknown = || Error::NoEnergy { reason: "the integral of a term is not known" };
    let integral = |f: &dyn Integrand| f.exact(domain).ok_or_else(unknown);
    let product = integral(f)? * integral(g)?;
    let values = |dirs: &[DVec3], values: &mut [f64]| product_into((f, dirs), (g, dirs), values);
    if domain == Domain::Hemisphere {
        let both = quadrature::integral(&a.product(&b), domain, &values)?;
        return Ok(ByParity { even: 2.0 * (both - product / domain.area()), odd: 0.0 });
    }
    if let Some(parts) = lens::centred_inner_product((f, &a), (g, &b)) {
        return Ok(parts);
    }
    let here = if a.is_apart_from(&b) {
        0.0
    } else {
        quadrature::integral(&a.product(&b), domain, &values)?
    };
    let mirrored = b.mirrored();
    let there = if a.is_even() || b.is_even() {
        here
    } else if a.is_apart_from(&mirrored) {
        0.0
    } else {
        let values = |dirs: &[DVec3], values: &mut [f64]| {
            let antipodes: Vec<DVec3> = dirs.iter().map(|&dir| -dir).collect();
            product_into((f, dirs), (g, &antipodes), values)
        };
        quadrature::integral(&a.product(&mirrored), domain, &values)?
    };
    Ok(ByParity { even: 0.5 * (here + there) - product / (4.0 * PI), odd: 0.5 * (here - there) })
}
