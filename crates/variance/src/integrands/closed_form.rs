use sphvar_samplers::Domain;

use crate::shape::Fold;
use crate::{Coefficients, Error, Integrand, quadrature};

/// What an integrand has on the sphere without quadrature; its hemisphere follows where the equator does
/// not cut it, and by quadrature where it does.
pub(super) trait ClosedForm: Integrand {
    /// `int F` over the sphere.
    fn sphere_integral(&self) -> Option<f64>;

    /// `int F^2` over the sphere.
    fn sphere_square(&self) -> Result<f64, Error>;

    /// The coefficients on the sphere.
    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error>;

    /// The fold of the hemisphere; none needed on the sphere.
    fn fold(&self, domain: Domain) -> Result<Fold, Error> {
        if domain == Domain::Sphere { Ok(Fold::Whole) } else { Ok(self.shape()?.fold(domain)) }
    }
}

/// [`Integrand::exact`] from closed forms.
pub(super) fn exact(f: &impl ClosedForm, domain: Domain) -> Option<f64> {
    match f.fold(domain).ok()? {
        Fold::Whole | Fold::Above => f.sphere_integral(),
        Fold::Even => Some(0.5 * f.sphere_integral()?),
        Fold::Cut => quadrature::integral(&f.shape().ok()?, domain, &|dir| f.eval(dir)).ok(),
    }
}

/// [`Integrand::coefficients`] from closed forms.
pub(super) fn coefficients(
    f: &impl ClosedForm,
    domain: Domain,
    lmax: usize,
) -> Result<Coefficients, Error> {
    match f.fold(domain)? {
        Fold::Whole => f.sphere_coefficients(lmax),
        Fold::Even => Ok(f.sphere_coefficients(lmax)?.even_part()),
        Fold::Above => Ok(f.sphere_coefficients(lmax)?.even_extension()),
        Fold::Cut => quadrature::coefficients(&f.shape()?, domain, lmax, &|dir| f.eval(dir)),
    }
}

/// [`Integrand::square`] from closed forms.
pub(super) fn square(f: &impl ClosedForm, domain: Domain) -> Result<f64, Error> {
    match f.fold(domain)? {
        Fold::Whole | Fold::Even => f.sphere_square(),
        Fold::Above => Ok(2.0 * f.sphere_square()?),
        Fold::Cut => quadrature::square(&f.shape()?, domain, &|dir| f.eval(dir)),
    }
}

/// The methods of [`Integrand`] that follow from [`ClosedForm`].
macro_rules! from_closed_form {
    () => {
        fn exact(&self, domain: sphvar_samplers::Domain) -> Option<f64> {
            crate::integrands::closed_form::exact(self, domain)
        }

        fn coefficients(
            &self,
            domain: sphvar_samplers::Domain,
            lmax: usize,
        ) -> Result<crate::Coefficients, crate::Error> {
            crate::integrands::closed_form::coefficients(self, domain, lmax)
        }

        fn square(&self, domain: sphvar_samplers::Domain) -> Result<f64, crate::Error> {
            crate::integrands::closed_form::square(self, domain)
        }
    };
}
pub(super) use from_closed_form;
