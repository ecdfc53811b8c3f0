use sphvar_samplers::{
    Domain, Ensemble, Pattern, PointSet, Purpose, Realizations, Sampler, Streams,
};
use sphvar_spectrum::Method;

use crate::Error;
use crate::kept_half::KeptHalf;

/// Where the points of an ensemble are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Points {
    /// Sphere sets.
    Sphere,
    /// Hemisphere sets, as the pattern makes them there; turned as lines (the projective plane).
    Hemisphere,
    /// What is left of sphere sets at z >= 0: how the thesis makes hemisphere sets of most patterns. Turned before
    /// the half is taken.
    KeptHalf,
}

/// The point sets of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct ThesisEnsemble {
    /// The pattern.
    pub pattern: Pattern,
    /// The number of points of a set; of [`Points::KeptHalf`] the number on the whole sphere, twice that of a half.
    pub n_points: usize,
    /// Where they are.
    pub points: Points,
    /// Whether every set is turned by a uniform rotation of its own.
    pub turned: bool,
}

impl ThesisEnsemble {
    /// Turned sets on the sphere, of the number of points that the pattern has next to `n_points`.
    #[must_use]
    pub fn sphere(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(n_points, Domain::Sphere);
        Self { pattern, n_points, points: Points::Sphere, turned: true }
    }

    /// Turned sets of the hemisphere, of the number of points that the pattern has next to `n_points`.
    #[must_use]
    pub fn hemisphere(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(n_points, Domain::Hemisphere);
        Self { pattern, n_points, points: Points::Hemisphere, turned: true }
    }

    /// Halves of turned sets on the sphere, with about `n_points` each.
    #[must_use]
    pub fn kept_half(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(2 * n_points, Domain::Sphere);
        Self { pattern, n_points, points: Points::KeptHalf, turned: true }
    }

    /// The same sets as the pattern makes them.
    #[must_use]
    pub fn unturned(self) -> Self {
        Self { turned: false, ..self }
    }

    /// Where the sets that the pattern makes live.
    #[must_use]
    pub fn domain(&self) -> Domain {
        match self.points {
            Points::Sphere | Points::KeptHalf => Domain::Sphere,
            Points::Hemisphere => Domain::Hemisphere,
        }
    }

    /// The number of points of a set that are used: of halves the expected one.
    #[must_use]
    pub fn used_points(&self) -> usize {
        match self.points {
            Points::Sphere | Points::Hemisphere => self.n_points,
            Points::KeptHalf => self.n_points.div_ceil(2),
        }
    }

    /// Set number `index` of the ensemble that spectra are taken of.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if it cannot be made.
    pub fn set(&self, seed: u64, index: u64) -> Result<Vec<glam::DVec3>, Error> {
        let mut set = PointSet::default();
        self.with_sets(seed, Purpose::Pattern, |sets| {
            Ok(sets.realize_into(index, &mut set, &())?)
        })?;
        Ok(set.points)
    }

    /// Hands the sets for a purpose to `work`.
    pub(crate) fn with_sets<T>(
        &self,
        seed: u64,
        purpose: Purpose,
        work: impl FnOnce(&dyn Ensemble) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let sampler = self.sampler()?;
        let sets = self.realizations(&*sampler, seed, purpose);
        match self.points {
            Points::Sphere | Points::Hemisphere => work(&sets),
            Points::KeptHalf => work(&KeptHalf(sets)),
        }
    }

    pub(crate) fn sampler(&self) -> Result<Box<dyn Sampler>, Error> {
        Ok(self.pattern.build(self.n_points, self.domain())?)
    }

    pub(crate) fn realizations<'a>(
        &self,
        sampler: &'a dyn Sampler,
        seed: u64,
        purpose: Purpose,
    ) -> Realizations<'a> {
        let streams = Streams::new(seed, purpose, self.pattern.stream_group(self.n_points));
        if self.turned {
            Realizations::rotated(sampler, streams)
        } else {
            Realizations::unrotated(sampler, streams)
        }
    }

    /// The nominal work of a set and its transform to degree `lmax`.
    pub(crate) fn work(&self, lmax: usize) -> f64 {
        self.pattern.nominal_work(self.n_points) + Method::Auto.nominal_work(self.n_points, lmax)
    }

    /// Words that tell it from every other.
    pub(crate) fn key(&self) -> String {
        let points = match self.points {
            Points::Sphere => "sphere",
            Points::Hemisphere => "hemisphere",
            Points::KeptHalf => "half",
        };
        let turned = if self.turned { "turned" } else { "unturned" };
        format!("{} n={} {points} {turned}", self.pattern, self.n_points)
    }
}
