use std::fmt;

use glam::DVec3;
use sphvar_sh::{ByParity, Domain, LmIndex};

use crate::quadrature::{self, Estimate, FIRST_NODES, MAX_FEATURE_DEGREE};
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// The relative error of all energies below which a function counts as known to rounding: the next
/// doubling squares it for smooth functions.
const RESOLVED: f64 = 1e-10;

/// The precision and the cost at which an [`AdaptiveFunction`] stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The error of the energies, summed over all degrees and relative to their total without the
    /// mean; above 0 and at most 0.1. A function of which it reaches 1e-10 counts as resolved.
    pub relative: f64,
    /// The number of values to take at least; features of an area of less than about `12 pi`
    /// divided by it may be missed.
    pub min_evaluations: usize,
    /// The number of values not to exceed, at least [`Self::MIN_EVALUATIONS`].
    pub max_evaluations: usize,
}

impl Tolerance {
    /// The values of the first three rules, which an error needs.
    pub const MIN_EVALUATIONS: usize = FIRST_NODES;

    pub(crate) fn checked(self) -> Result<Self, Error> {
        let Self { relative, max_evaluations, .. } = self;
        if !(relative > 0.0 && relative <= 0.1) {
            let range = "above 0 and at most 0.1";
            return Err(Error::Parameter { name: "relative tolerance", range, got: relative });
        }
        if max_evaluations < Self::MIN_EVALUATIONS {
            let (name, got) = ("max_evaluations", max_evaluations as f64);
            return Err(Error::Parameter {
                name,
                range: "at least 14290 (the first three rules)",
                got,
            });
        }
        Ok(self)
    }

    /// Returns the degree of the narrowest features that `min_evaluations` values resolve: rules of n
    /// rings take 2 n^2 values, all rules before as many again, and features of degree 2n are those
    /// that n rings do not miss.
    pub(super) fn feature_degree(self) -> usize {
        self.min_evaluations.isqrt().clamp(1, MAX_FEATURE_DEGREE)
    }
}

impl Default for Tolerance {
    /// To rounding for smooth functions, at least 16384 and at most some four million values.
    fn default() -> Self {
        Self { relative: 1e-12, min_evaluations: 1 << 14, max_evaluations: 1 << 22 }
    }
}

/// A function of which nothing but values is known. Its degree is found by doubling until the
/// energies are known to a [`Tolerance`]; the error that remains is part of every prediction.
///
/// Rules of 32, 45, 64, 90, ... rings, every one in an orientation of its own, give integral,
/// energies per degree and total. Results of a rule are compared with those of the two before, of
/// which one has half the degree: the larger difference is the error, also of every
/// sum of energies and so of predictions. The doubling stops where the sum of errors over all degrees is within the tolerance, or at the largest number of
/// values.
///
/// - A smooth function is resolved to rounding after a few doublings: integral, coefficients and
///   energies of any degree are exact on this domain and on the hemisphere, and sums, products and
///   rotations of it are as for a [`SampledFunction`](crate::SampledFunction) of the degree found.
/// - For a function with kinks or jumps the doubling converges slowly, as a power of the degree.
///   [`energy`](Integrand::energy) then ends at half the degree of the last rule and has errors
///   ([`Energy::errors`]). Sums, products and rotations of the function are estimated anew as a
///   whole, with their own errors. Declared edges give exact results, see
///   [`SampledFunction::with_edge`](crate::SampledFunction::with_edge).
/// - A feature that no node hits is missed, without a sign of it: with the default of 16384 values at
///   least, peaks that vanish beyond some 2 degrees. [`Tolerance::min_evaluations`] lowers the limit.
///
/// On the hemisphere the function is evaluated above the equator alone.
///
/// # Performance
///
/// A rule of n rings takes `2 n^2` values and `n^3/4` steps of a transform, and all rules before
/// as many values again. The default takes at most four million values, in batches
/// ([`Integrand::eval_into`]); an error from a batch stops the work.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{AdaptiveFunction, Domain, Integrand, Tolerance};
///
/// let smooth = |d: DVec3| (d.x + 2.0 * d.z).exp();
/// let f = AdaptiveFunction::new(smooth, Domain::Sphere, Tolerance::default())?;
/// let a = 5f64.sqrt();
/// let exact = 4.0 * std::f64::consts::PI * a.sinh()/a;
/// assert!((f.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-14);
/// assert!(f.energy(Domain::Sphere, 30)?.errors().is_none());
///
/// // A jump, of which 200 000 values are not enough for more than some digits.
/// let jump = |d: DVec3| f64::from(d.x + 2.0 * d.z > 1.0);
/// let tolerance = Tolerance { max_evaluations: 200_000, ..Tolerance::default() };
/// let f = AdaptiveFunction::new(jump, Domain::Sphere, tolerance)?;
/// let energy = f.energy(Domain::Sphere, 30)?;
/// let (total, error) = (energy.centred().sum(), energy.centred_stderr().sum());
/// assert!(error > 1e-6 * total && error < 1e-2 * total);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone)]
pub struct AdaptiveFunction<F> {
    function: F,
    domain: Domain,
    tolerance: Tolerance,
    estimate: Estimate,
}

impl<F> fmt::Debug for AdaptiveFunction<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AdaptiveFunction")
            .field("domain", &self.domain)
            .field("n_evaluations", &self.estimate.n_evaluations)
            .field("relative_error", &self.estimate.relative_error)
            .finish_non_exhaustive()
    }
}

impl<F: Integrand> AdaptiveFunction<F> {
    /// Returns the function with its energies on a domain; a closure `Fn(DVec3) -> f64` is an
    /// [`Integrand`].
    ///
    /// A tolerance that is not reached is not an error, see
    /// [`relative_error`](Self::relative_error).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a tolerance out of range, [`Error::Evaluation`] with the direction
    /// for a value that is NaN or infinite or whose evaluation panics, [`Error::Magnitude`] for
    /// values whose squares overflow or underflow, and those of [`Integrand::eval_into`].
    pub fn new(function: F, domain: Domain, tolerance: Tolerance) -> Result<Self, Error> {
        let Tolerance { relative, min_evaluations, max_evaluations } = tolerance.checked()?;
        let evaluations = [min_evaluations, max_evaluations];
        let estimate = quadrature::doubled(&function, domain, relative, evaluations)?;
        Ok(Self { function, domain, tolerance, estimate })
    }

    /// Returns the error of the energies, summed over all degrees and relative to
    /// their total without the mean; 0 within rounding.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.estimate.relative_error
    }

    /// Returns the integral over the domain and its error.
    #[must_use]
    pub fn integral(&self) -> (f64, f64) {
        self.estimate.integral
    }

    /// Returns the number of values taken.
    #[must_use]
    pub fn n_evaluations(&self) -> usize {
        self.estimate.n_evaluations
    }

    /// Returns the degree of the polynomial that the function equals to rounding; `None` if values
    /// do not resolve it.
    #[must_use]
    pub fn degree(&self) -> Option<usize> {
        // The even extension from the hemisphere has energy of all degrees.
        (self.estimate.relative_error <= RESOLVED).then(|| match self.domain {
            Domain::Sphere => self.estimate.effective_degree(),
            Domain::Hemisphere => self.estimate.per_degree.len() - 1,
        })
    }

    /// Returns the shape for a quadrature on a domain.
    fn shape_on(&self, domain: Domain) -> Result<Shape, Error> {
        if self.domain == Domain::Hemisphere && domain == Domain::Sphere {
            let reason = "its degree was found on the hemisphere; build it for the sphere";
            return Err(Error::NoEnergy { reason });
        }
        self.shape()
    }
}

impl<F: Integrand> Integrand for AdaptiveFunction<F> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.function.eval(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.function.eval_into(dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        let reason = "its values do not resolve it, so its energies are estimates; declare its degree \
                      and its edges";
        self.degree().map(Shape::smooth).ok_or(Error::NoEnergy { reason })
    }

    /// Returns the integral if the function is resolved; see
    /// [`integral`](AdaptiveFunction::integral) otherwise.
    fn exact(&self, domain: Domain) -> Option<f64> {
        let shape = self.shape_on(domain).ok()?;
        if domain == self.domain {
            return Some(self.estimate.integral.0);
        }
        quadrature::integral(&shape, domain, &|dirs, values| self.eval_into(dirs, values)).ok()
    }

    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        let exact = || Some((self.exact(domain)?, 0.0));
        if domain == self.domain { Some(self.estimate.integral) } else { exact() }
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        quadrature::coefficients(&self.shape_on(domain)?, domain, lmax, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        let shape = self.shape_on(domain)?;
        if domain == self.domain {
            return Ok(self.estimate.energy.centred());
        }
        quadrature::centred_square(&shape, domain, &|dirs, values| self.eval_into(dirs, values))
    }

    /// Returns the energies without errors if the function is resolved, otherwise estimates on the
    /// domain of the function, to at most half the degree of the last rule.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let estimate = &self.estimate.energy;
        match self.shape_on(domain) {
            Err(_) if domain == self.domain => Ok(estimate.truncated(lmax)),
            Err(reason) => Err(reason),
            Ok(shape) if domain == Domain::Sphere => {
                LmIndex::new(lmax)?;
                // Beyond its degree a polynomial has no energy.
                let mut per_degree = self.estimate.per_degree[..=shape.degree()].to_vec();
                per_degree.resize(lmax + 1, 0.0);
                Ok(Energy::new(domain, per_degree, estimate.centred()))
            }
            Ok(_) => {
                let per_degree = self.coefficients(domain, lmax)?.energy_per_degree()?;
                Ok(Energy::new(domain, per_degree, self.centred_square(domain)?))
            }
        }
    }

    /// Returns that of the features which [`Tolerance::min_evaluations`] values do not miss, so that
    /// a sum or product with the function is estimated as a whole where it is not resolved.
    fn feature_degree(&self) -> Option<usize> {
        Some(self.tolerance.feature_degree())
    }

    /// Returns the estimate of the last rule.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        if domain == self.domain {
            return self.estimate.kurtosis;
        }
        quadrature::kurtosis(&self.shape_on(domain).ok()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }
}
