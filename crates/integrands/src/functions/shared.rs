use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use glam::DVec3;
use sphvar_sh::{ByParity, Domain};

use crate::integrand::forwarded;
use crate::{Coefficients, Energy, EnvironmentMap, Error, Integrand, Shape};

/// An integrand that several expressions or threads own together, such as a function of the program
/// that an [`IntegrandResolver`](crate::IntegrandResolver) supplies.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{Domain, Integrand, Product, SampledFunction, SharedFunction};
///
/// let wave = SharedFunction::new(SampledFunction::new(|d: DVec3| d.x, 1));
/// let square = Product::new(wave.clone(), wave);
/// assert!((square.exact(Domain::Sphere).unwrap() - 4.0 / 3.0 * std::f64::consts::PI).abs() < 1e-14);
/// ```
#[derive(Clone)]
pub struct SharedFunction(Arc<dyn Integrand + Send + Sync>);

impl SharedFunction {
    /// Returns a function that can be cloned without its contents.
    #[must_use]
    pub fn new(function: impl Integrand + Send + 'static) -> Self {
        Self(Arc::new(function))
    }
}

impl From<Arc<dyn Integrand + Send + Sync>> for SharedFunction {
    fn from(function: Arc<dyn Integrand + Send + Sync>) -> Self {
        Self(function)
    }
}

impl Deref for SharedFunction {
    type Target = dyn Integrand + Send + Sync;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl fmt::Debug for SharedFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SharedFunction").finish_non_exhaustive()
    }
}

impl Integrand for SharedFunction {
    forwarded!();
}
