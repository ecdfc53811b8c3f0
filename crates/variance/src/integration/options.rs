use std::fmt;

use sphvar_samplers::{Domain, Pattern, PointSet, Sampler, SamplerFamily};

use super::{COPIES, Estimate, FIRST_COUNT, realizations};
use crate::{Error, student_quantile};

/// The tolerance, the pattern and the limits of an integration.
#[derive(Clone, Copy)]
pub struct IntegrationOptions<'a> {
    /// The relative tolerance, at least 0.
    pub rtol: f64,
    /// The absolute tolerance, at least 0; needed where the integral may be 0. Not both tolerances
    /// may be 0.
    pub atol: f64,
    /// The maximum number of evaluations of the function, over all levels and copies.
    pub max_points: u64,
    /// The probability that an error bounds the deviation from the integral, in (0, 1).
    pub confidence: f64,
    /// The pattern of the points.
    pub pattern: &'a dyn SamplerFamily,
    /// The domain of the integral.
    pub domain: Domain,
    /// The seed of rotations and random patterns.
    pub seed: u64,
}

impl Default for IntegrationOptions<'_> {
    /// Returns a relative tolerance of 1e-4 with 95 % confidence on the sphere, with at most 10
    /// million evaluations. The pattern is the Fibonacci lattice, which has any number of points
    /// and the fastest convergence of the inexpensive patterns for both jumps and smooth functions.
    fn default() -> Self {
        Self {
            rtol: 1e-4,
            atol: 0.0,
            max_points: 10_000_000,
            confidence: 0.95,
            pattern: &Pattern::FIBONACCI,
            domain: Domain::Sphere,
            seed: 0,
        }
    }
}

impl fmt::Debug for IntegrationOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("IntegrationOptions")
            .field("rtol", &self.rtol)
            .field("atol", &self.atol)
            .field("max_points", &self.max_points)
            .field("confidence", &self.confidence)
            .field("pattern", &self.pattern)
            .field("domain", &self.domain)
            .field("seed", &self.seed)
            .finish()
    }
}

impl IntegrationOptions<'_> {
    /// Returns the nodes of an integral: the points of all copies of a set of
    /// [`n_points`](super::Integral::n_points) points, with weights that sum to the area of the
    /// domain. `sum_k w_k f(x_k)` is the value of the integral.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Spectrum`] with the error of the sampler if `n_points` is not valid.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_variance::{IntegrationOptions, integrate};
    ///
    /// let f = |d: glam::DVec3| (d.x * d.y).exp();
    /// let options = IntegrationOptions::default();
    /// let integral = integrate(&f, &options, &())?;
    /// let nodes = options.nodes(integral.n_points)?;
    /// let sum: f64 = nodes.points.iter().zip(&nodes.weights).map(|(x, w)| w * f(*x)).sum();
    /// assert!((sum - integral.value()).abs() < 1e-12);
    /// # Ok::<(), sphvar_variance::Error>(())
    /// ```
    pub fn nodes(&self, n_points: usize) -> Result<PointSet, Error> {
        let sampler = self.sampler(n_points)?;
        let sets = realizations(&*sampler, self.seed);
        let mut nodes = PointSet::default();
        for index in 0..COPIES as u64 {
            let mut set = sets.realize(index)?;
            let share = self.domain.area() / COPIES as f64;
            if set.weights.is_empty() {
                set.weights.resize(set.points.len(), 1.0);
            }
            set.normalize_weights();
            let sum = set.weights.iter().copied().collect::<sphvar_sh::CompensatedSum>().value();
            nodes.points.append(&mut set.points);
            nodes.weights.extend(set.weights.iter().map(|w| share * (w / sum)));
        }
        Ok(nodes)
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let wrong = |name, range, got| Err(Error::Parameter { name, range, got });
        for (name, got) in [
            ("the relative tolerance of an integral", self.rtol),
            ("the absolute tolerance of an integral", self.atol),
        ] {
            if !(got >= 0.0 && got.is_finite()) {
                return wrong(name, "finite and at least 0", got);
            }
        }
        if self.rtol <= 0.0 && self.atol <= 0.0 {
            return wrong("the relative or the absolute tolerance", "positive", 0.0);
        }
        let confidence = self.confidence;
        if !(confidence > 0.0 && confidence < 1.0) {
            return wrong("the confidence of an integral", "between 0 and 1", confidence);
        }
        Ok(())
    }

    /// Returns the quantile of Student's distribution with half the probability of error; see the
    /// module.
    pub(super) fn quantile(&self) -> f64 {
        student_quantile(1.0 - (1.0 - self.confidence) / 4.0, COPIES as f64 - 1.0)
    }

    /// Returns whether an error is within the tolerance.
    pub(super) fn is_met(&self, estimate: Estimate) -> bool {
        estimate.error <= self.atol.max(self.rtol * estimate.value.abs())
    }

    pub(super) fn sampler(&self, n_points: usize) -> Result<Box<dyn Sampler>, Error> {
        let sampler = self.pattern.build(n_points, self.domain)?;
        if sampler.domain() != self.domain {
            return Err(Error::OtherDomain { expected: self.domain, got: sampler.domain() });
        }
        Ok(sampler)
    }

    /// Returns the number of points of the first level.
    pub(super) fn first_count(&self) -> Result<usize, Error> {
        let affordable = usize::try_from(self.max_points).unwrap_or(usize::MAX) / COPIES;
        let mut first = self.pattern.nearest_count(FIRST_COUNT.min(affordable), self.domain);
        if first > affordable {
            first = self.pattern.nearest_count(1, self.domain);
        }
        if first > affordable {
            return Err(Error::Parameter {
                name: "the maximum number of evaluations",
                range: "at least that of 16 copies of the pattern's smallest set",
                got: self.max_points as f64,
            });
        }
        Ok(first)
    }

    /// Returns the valid count nearest to twice `n_points`, or the next larger one; `None` if the
    /// pattern has none.
    pub(super) fn next_count(&self, n_points: usize) -> Option<usize> {
        let mut requested = n_points;
        loop {
            requested = requested.checked_mul(2)?;
            let next = self.pattern.nearest_count(requested, self.domain);
            if next > n_points {
                return Some(next);
            }
        }
    }
}
