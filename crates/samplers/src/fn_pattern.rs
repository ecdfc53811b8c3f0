use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use rand::Rng;

use crate::{Domain, Error, PointSet, Sampler, SamplerFamily};

type Function = dyn Fn(usize, &mut dyn Rng) -> Vec<DVec3> + Send + Sync;

/// A pattern given by a function of the number of points and a random generator, valid for every
/// number of points.
///
/// Implement [`Sampler`] and [`SamplerFamily`] instead for a pattern with weights, with other valid
/// numbers of points, or with realizations that can fail.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use rand::RngExt;
/// use sphvar_samplers::{Domain, FnPattern, SamplerFamily};
///
/// // The i-th of N points is uniform in the i-th of N zones of equal area.
/// let zones = FnPattern::new("zones", Domain::Sphere, |n, rng| {
///     (0..n)
///         .map(|i| {
///             let z: f64 = 1.0 - 2.0 * (i as f64 + rng.random::<f64>()) / n as f64;
///             let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
///             let rho = (1.0 - z * z).max(0.0).sqrt();
///             DVec3::new(rho * cos, rho * sin, z)
///         })
///         .collect()
/// });
/// assert_eq!(zones.build(100, Domain::Sphere)?.n_points(), 100);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone)]
pub struct FnPattern {
    name: &'static str,
    domain: Domain,
    function: Arc<Function>,
}

impl FnPattern {
    /// Returns the pattern of a function that returns N unit vectors for N, with z >= 0 on the
    /// hemisphere. The name identifies the pattern in results and determines its random streams.
    pub fn new(
        name: &'static str,
        domain: Domain,
        function: impl Fn(usize, &mut dyn Rng) -> Vec<DVec3> + Send + Sync + 'static,
    ) -> Self {
        Self { name, domain, function: Arc::new(function) }
    }
}

impl fmt::Debug for FnPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FnPattern")
            .field("name", &self.name)
            .field("domain", &self.domain)
            .finish_non_exhaustive()
    }
}

impl fmt::Display for FnPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name)
    }
}

impl SamplerFamily for FnPattern {
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points, and [`Error::Infeasible`] on a domain other than that of
    /// the pattern.
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: self.name.to_owned() });
        }
        if domain != self.domain {
            let reason = format!("the pattern is on the {}, not on the {domain}", self.domain);
            return Err(Error::Infeasible { pattern: self.name, n_points, reason });
        }
        Ok(Box::new(FnSampler { pattern: self.clone(), n_points }))
    }
}

/// [`FnPattern`] with a number of points.
#[derive(Debug)]
struct FnSampler {
    pattern: FnPattern,
    n_points: usize,
}

impl Sampler for FnSampler {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.pattern.domain
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = (self.pattern.function)(self.n_points, rng);
        if points.len() != self.n_points {
            let (name, got) = (self.pattern.name, points.len());
            let reason = format!("{name} returned {got} points instead of {}", self.n_points);
            return Err(Error::Given { reason });
        }
        *set.start() = points;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Purpose, Realizations, Streams};

    fn poles(n: usize, _: &mut dyn Rng) -> Vec<DVec3> {
        vec![DVec3::Z; n]
    }

    #[test]
    fn realizations_are_those_of_the_function() {
        let pattern = FnPattern::new("poles", Domain::Hemisphere, poles);
        let sampler = pattern.build(3, Domain::Hemisphere).unwrap();
        let sets = Realizations::unrotated(&*sampler, Streams::new(0, Purpose::Pattern, 3));
        let set = sets.realize(0).unwrap();
        assert_eq!((set.points, set.weights.len()), (vec![DVec3::Z; 3], 0));
        assert_eq!(format!("{pattern:8}|"), "poles   |");
    }

    #[test]
    fn streams_depend_on_name_and_number() {
        let group = |name, n| {
            let pattern = FnPattern::new(name, Domain::Sphere, poles);
            pattern.build(n, Domain::Sphere).unwrap().stream_group()
        };
        assert_eq!(group("a", 3), group("a", 3));
        assert!(group("a", 3) != group("b", 3) && group("a", 3) != group("a", 4));
    }

    #[test]
    fn invalid_uses_are_errors() {
        let pattern = FnPattern::new("poles", Domain::Sphere, poles);
        assert!(matches!(pattern.build(0, Domain::Sphere), Err(Error::NoPoints { .. })));
        let error = pattern.build(3, Domain::Hemisphere).unwrap_err().to_string();
        assert!(error.contains("on the sphere"), "{error}");
        for (function, part) in [
            (
                Box::new(|n: usize, _: &mut dyn Rng| vec![DVec3::Z; n + 1]) as Box<Function>,
                "4 points",
            ),
            (Box::new(|n: usize, _: &mut dyn Rng| vec![DVec3::ZERO; n]), "point 0"),
        ] {
            let pattern = FnPattern::new("odd", Domain::Sphere, function);
            let sampler = pattern.build(3, Domain::Sphere).unwrap();
            let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 3));
            let error = sets.realize(0).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
