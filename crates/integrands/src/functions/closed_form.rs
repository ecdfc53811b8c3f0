use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use crate::shape::Fold;
use crate::{Coefficients, Error, Integrand, quadrature};

/// Closed forms of an integrand on the sphere. Results on the hemisphere follow from them if the
/// equator does not cut the function, and from quadrature otherwise.
pub(super) trait ClosedForm: Integrand {
    /// Returns `int F` over the sphere.
    fn sphere_integral(&self) -> Option<f64>;

    /// Returns `int (F - mean F)^2` over the sphere of the even and of the odd part of F.
    fn sphere_centred_square(&self) -> Result<ByParity, Error>;

    /// Returns the coefficients on the sphere.
    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error>;

    /// Returns the fold of the hemisphere; not needed on the sphere.
    fn fold(&self, domain: Domain) -> Result<Fold, Error> {
        if domain == Domain::Sphere { Ok(Fold::Whole) } else { Ok(self.shape()?.fold(domain)) }
    }
}

/// [`Integrand::exact`] from closed forms.
pub(super) fn exact(f: &impl ClosedForm, domain: Domain) -> Option<f64> {
    match f.fold(domain).ok()? {
        Fold::Whole | Fold::Above => f.sphere_integral(),
        Fold::Even => Some(0.5 * f.sphere_integral()?),
        Fold::Cut => quadrature::integral(&f.shape().ok()?, domain, &|dirs, values| {
            f.eval_into(dirs, values)
        })
        .ok(),
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
        Fold::Cut => quadrature::coefficients(&f.shape()?, domain, lmax, &|dirs, values| {
            f.eval_into(dirs, values)
        }),
    }
}

/// [`Integrand::centred_square`] from closed forms.
pub(super) fn centred_square(f: &impl ClosedForm, domain: Domain) -> Result<ByParity, Error> {
    let even = |even: f64| ByParity { even, odd: 0.0 };
    match f.fold(domain)? {
        Fold::Whole => f.sphere_centred_square(),
        Fold::Even => Ok(even(f.sphere_centred_square()?.even)),
        // The even extension is twice the even part.
        Fold::Above => Ok(even(4.0 * f.sphere_centred_square()?.even)),
        Fold::Cut => quadrature::centred_square(&f.shape()?, domain, &|dirs, values| {
            f.eval_into(dirs, values)
        }),
    }
}

/// The methods of [`Integrand`] that follow from [`ClosedForm`].
macro_rules! from_closed_form {
    () => {
        fn exact(&self, domain: sphvar_sh::Domain) -> Option<f64> {
            crate::functions::closed_form::exact(self, domain)
        }

        fn coefficients(
            &self,
            domain: sphvar_sh::Domain,
            lmax: usize,
        ) -> Result<crate::Coefficients, crate::Error> {
            crate::functions::closed_form::coefficients(self, domain, lmax)
        }

        fn centred_square(
            &self,
            domain: sphvar_sh::Domain,
        ) -> Result<sphvar_sh::ByParity, crate::Error> {
            crate::functions::closed_form::centred_square(self, domain)
        }
    };
}
pub(super) use from_closed_form;
