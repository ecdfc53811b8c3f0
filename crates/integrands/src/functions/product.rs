use glam::DVec3;
use sphvar_sh::{ByParity, Domain};

use super::environment::ZonalProduct;
use super::inner_product::{inner_product, product_into};
use crate::quadrature::{self, Estimates};
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// The product of two integrands, such as light and the lobe that reflects it.
///
/// Products of an environment map and a function of z follow from the rows of the map. Otherwise the
/// integral is an inner product of coefficients where one factor has no edges; all other results come from quadrature over rings that are split at the edges of both. Where edges of both cross, energies per degree end at a degree of about 2000 ([`energy_degree`](Integrand::energy_degree)). Factors without a
/// known shape (closures, HEALPix maps) provide the values and at most the integral.
///
/// # Examples
///
/// ```
/// use glam::DQuat;
/// use sphvar_integrands::{Cap, ClampedCosine, Domain, Integrand, Product, Rotated};
///
/// // A cap of 30 degrees about an axis 40 degrees from the surface normal, as seen by the surface:
/// // while it lies above the horizon its irradiance is pi sin^2(30) cos(40).
/// let tilt = DQuat::from_rotation_x(40f64.to_radians());
/// let light = Rotated::new(Cap::from_degrees(30.0)?, tilt)?;
/// let product = Product::new(light, ClampedCosine);
/// let exact = 0.25 * std::f64::consts::PI * 40f64.to_radians().cos();
/// assert!((product.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-13);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Product<A, B> {
    first: A,
    second: B,
    estimates: Estimates,
}

impl<A: Integrand, B: Integrand> Product<A, B> {
    /// Returns the product of `first` and `second`.
    #[must_use]
    pub fn new(first: A, second: B) -> Self {
        Self { first, second, estimates: Estimates::default() }
    }

    fn zonal_product(&self) -> Option<ZonalProduct<'_>> {
        ZonalProduct::of(&self.first, &self.second)
    }
}

impl<A: Integrand, B: Integrand> Integrand for Product<A, B> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.first.eval(dir) * self.second.eval(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        product_into((&self.first, dirs), (&self.second, dirs), values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(self.first.shape()?.product(&self.second.shape()?))
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        if let Some(product) = self.zonal_product() {
            return product.integral(domain).ok();
        }
        // The even extension contains the hemisphere twice.
        let copies = if domain == Domain::Sphere { 1.0 } else { 0.5 };
        Some(copies * inner_product(&self.first, &self.second, domain).ok()?)
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        match self.zonal_product() {
            Some(product) => product.coefficients(domain, lmax),
            None => quadrature::coefficients(&self.shape()?, domain, lmax, &|dirs, values| {
                self.eval_into(dirs, values)
            }),
        }
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        if let Some(product) = self.zonal_product()
            && let Some(parts) = product.centred_square(domain)?
        {
            return Ok(parts);
        }
        quadrature::centred_square(&self.shape()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        quadrature::kurtosis_of_values(self.shape().ok().as_ref(), domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        self.estimates.integral(self, domain)
    }

    /// Returns estimates with their errors where exact energies would need too many values.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.estimates.energy(self, domain, lmax)
    }

    fn energy_degree(&self, domain: Domain, lmax: usize) -> usize {
        match (self.zonal_product(), self.shape()) {
            (None, Ok(shape)) => quadrature::affordable_degree(&shape, domain, lmax),
            _ => lmax,
        }
    }

    fn feature_degree(&self) -> Option<usize> {
        Some(self.first.feature_degree()?.max(self.second.feature_degree()?))
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.first.band_limit()? + self.second.band_limit()?)
    }
}
