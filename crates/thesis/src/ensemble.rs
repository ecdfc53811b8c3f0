use sphvar_samplers::{
    Domain, Ensemble, Pattern, PointSet, Purpose, Realizations, Sampler, Streams,
};
use sphvar_spectrum::Method;

use crate::Error;
use crate::visible_half::VisibleHalf;

/// The domain and construction of the points of an ensemble.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Points {
    /// Sphere sets.
    Sphere,
    /// Hemisphere sets as the pattern generates them; rotated as antipodal pairs.
    Hemisphere,
    /// The visible half (z >= 0) of sphere sets, rotated before the cut. This is how the thesis
    /// generates the hemisphere sets of most patterns.
    VisibleHalf,
}

/// The point sets of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct ThesisEnsemble {
    /// The pattern.
    pub pattern: Pattern,
    /// The number of points of a set; for [`Points::VisibleHalf`], the number on the whole sphere,
    /// twice that of a half.
    pub n_points: usize,
    /// The domain and construction of the points.
    pub points: Points,
    /// Whether every set is rotated by an independent uniform rotation.
    pub rotated: bool,
}

impl ThesisEnsemble {
    /// Returns rotated sets on the sphere with the valid count nearest to `n_points`.
    #[must_use]
    pub fn sphere(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(n_points, Domain::Sphere);
        Self { pattern, n_points, points: Points::Sphere, rotated: true }
    }

    /// Returns rotated sets of the hemisphere with the valid count nearest to `n_points`.
    #[must_use]
    pub fn hemisphere(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(n_points, Domain::Hemisphere);
        Self { pattern, n_points, points: Points::Hemisphere, rotated: true }
    }

    /// Returns visible halves of rotated sets on the sphere, with about `n_points` each.
    #[must_use]
    pub fn visible_half(pattern: Pattern, n_points: usize) -> Self {
        let n_points = pattern.nearest_count(2 * n_points, Domain::Sphere);
        Self { pattern, n_points, points: Points::VisibleHalf, rotated: true }
    }

    /// Returns the same sets without rotation.
    #[must_use]
    pub fn unrotated(self) -> Self {
        Self { rotated: false, ..self }
    }

    /// Returns the domain of the sets that the pattern generates.
    #[must_use]
    pub fn domain(&self) -> Domain {
        match self.points {
            Points::Sphere | Points::VisibleHalf => Domain::Sphere,
            Points::Hemisphere => Domain::Hemisphere,
        }
    }

    /// Returns the number of points of a set that are used; for halves, the expected number.
    #[must_use]
    pub fn used_points(&self) -> usize {
        match self.points {
            Points::Sphere | Points::Hemisphere => self.n_points,
            Points::VisibleHalf => self.n_points.div_ceil(2),
        }
    }

    /// Returns set `index` of the ensemble used for spectra.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if it cannot be generated.
    pub fn set(&self, seed: u64, index: u64) -> Result<Vec<glam::DVec3>, Error> {
        let mut set = PointSet::default();
        self.with_sets(seed, Purpose::Pattern, |sets| {
            Ok(sets.realize_into(index, &mut set, &())?)
        })?;
        Ok(set.points)
    }

    /// Calls `work` with the sets for a purpose.
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
            Points::VisibleHalf => work(&VisibleHalf(sets)),
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
        if self.rotated {
            Realizations::rotated(sampler, streams)
        } else {
            Realizations::unrotated(sampler, streams)
        }
    }

    /// Returns the nominal work of a set and its transform to degree `lmax`.
    pub(crate) fn work(&self, lmax: usize) -> f64 {
        self.pattern.nominal_work(self.n_points) + Method::Auto.nominal_work(self.n_points, lmax)
    }

    /// Returns a text that distinguishes the ensemble from all others.
    pub(crate) fn key(&self) -> String {
        let points = match self.points {
            Points::Sphere => "sphere",
            Points::Hemisphere => "hemisphere",
            Points::VisibleHalf => "half",
        };
        let rotated = if self.rotated { "rotated" } else { "unrotated" };
        format!("{} n={} {points} {rotated}", self.pattern, self.n_points)
    }
}
