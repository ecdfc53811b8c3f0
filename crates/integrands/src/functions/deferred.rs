use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;
use sphvar_sh::{ByParity, Domain};

use super::{AdaptiveFunction, Tolerance};
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// An [`AdaptiveFunction`] whose values are taken when they are first needed, on the domain of the
/// first call that needs them: nothing is evaluated for estimates of the integral alone.
///
/// On the hemisphere, the function alone is evaluated above the equator only. Products and rotations
/// need its degree on the whole sphere, unless it is declared to have
/// [values above the equator only](Self::above_equator).
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{DeferredFunction, Domain, Integrand, Tolerance};
///
/// // Below the equator the root is NaN.
/// let f = DeferredFunction::new(|d: DVec3| d.z.sqrt(), Tolerance::default())?;
/// let (integral, error) = f.integral_estimate(Domain::Hemisphere).unwrap();
/// assert!((integral - 4.0 / 3.0 * std::f64::consts::PI).abs() <= 2.0 * error && error < 1e-4);
/// assert!(f.energy(Domain::Sphere, 10).unwrap_err().to_string().contains("is NaN"));
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone)]
pub struct DeferredFunction<F> {
    function: F,
    tolerance: Tolerance,
    /// Whether it has values above the equator only.
    is_above: bool,
    sphere: OnceLock<Result<AdaptiveFunction<F>, Error>>,
    hemisphere: OnceLock<Result<AdaptiveFunction<F>, Error>>,
}

impl<F> fmt::Debug for DeferredFunction<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeferredFunction")
            .field("tolerance", &self.tolerance)
            .field("is_above", &self.is_above)
            .finish_non_exhaustive()
    }
}

impl<F: Integrand + Clone> DeferredFunction<F> {
    /// Returns the function, which is not evaluated yet.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a tolerance out of range. Those of [`AdaptiveFunction::new`] are
    /// errors of the calls that need its values.
    pub fn new(function: F, tolerance: Tolerance) -> Result<Self, Error> {
        Ok(Self {
            function,
            tolerance: tolerance.checked()?,
            is_above: false,
            sphere: OnceLock::new(),
            hemisphere: OnceLock::new(),
        })
    }

    /// Declares that the function has values above the equator only, so that also its products are
    /// not evaluated below.
    #[must_use]
    pub fn above_equator(self) -> Self {
        Self { is_above: true, ..self }
    }

    /// Returns the function with its energies on a domain.
    ///
    /// # Errors
    ///
    /// Those of [`AdaptiveFunction::new`].
    pub fn on(&self, domain: Domain) -> Result<&AdaptiveFunction<F>, Error> {
        let (cell, domain) = match domain {
            Domain::Sphere if !self.is_above => (&self.sphere, Domain::Sphere),
            _ => (&self.hemisphere, Domain::Hemisphere),
        };
        let found = cell
            .get_or_init(|| AdaptiveFunction::new(self.function.clone(), domain, self.tolerance));
        found.as_ref().map_err(Error::clone)
    }
}

impl<F: Integrand + Clone + Send> Integrand for DeferredFunction<F> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.function.eval(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.function.eval_into(dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        self.on(Domain::Sphere)?.shape()
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        self.on(domain).ok()?.exact(domain)
    }

    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        self.on(domain).ok()?.integral_estimate(domain)
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        self.on(domain)?.coefficients(domain, lmax)
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        self.on(domain)?.centred_square(domain)
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        self.on(domain).ok()?.kurtosis(domain)
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.on(domain)?.energy(domain, lmax)
    }

    fn feature_degree(&self) -> Option<usize> {
        Some(self.tolerance.feature_degree())
    }
}
