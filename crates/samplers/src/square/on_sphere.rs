use std::f64::consts::TAU;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::Choice;
use sphvar_warps::{ConcentricHemisphere, OctahedralSphere, Warp, archimedes};

use super::OnFaces;
use crate::{Domain, Error, PointSet, Progress, Sampler, SetDistribution, SquareSampler};

/// The map of a pattern of the square to directions. All preserve areas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SphereMap {
    /// The whole square, by the map of Archimedes: heights and longitudes.
    #[default]
    Cylinder,
    /// The whole square, by the octahedral map (Clarberg 2008): each of 4^k equal squares becomes a
    /// cell of moderate aspect ratio. On the hemisphere the concentric map (Shirley and Chiu 1997).
    Octahedral,
    /// A pattern of its own on each of the twelve faces of HEALPix in turn, on the hemisphere on six:
    /// see [`OnFaces`].
    Healpix,
}

impl Choice for SphereMap {
    const CHOICES: &'static [(&'static str, Self)] = &[
        ("cylinder", Self::Cylinder),
        ("octahedral", Self::Octahedral),
        ("healpix", Self::Healpix),
    ];
}

impl SphereMap {
    /// Returns the sampler of `n_points` directions of the patterns on the square that `pattern`
    /// returns for numbers of points.
    ///
    /// # Errors
    ///
    /// Those of `pattern`.
    pub(crate) fn build<P: SquareSampler + 'static>(
        self,
        n_points: usize,
        domain: Domain,
        pattern: impl Fn(usize) -> Result<P, Error>,
    ) -> Result<Box<dyn Sampler>, Error> {
        Ok(match self {
            Self::Cylinder => Box::new(OnSphere::new(pattern(n_points)?, domain)),
            Self::Octahedral => Box::new(OnSphere::octahedral(pattern(n_points)?, domain)),
            Self::Healpix => Box::new(OnFaces::new(n_points, domain, pattern)?),
        })
    }
}

/// A pattern of the square mapped to the sphere or the hemisphere by an area-preserving map: by
/// default that of Archimedes.
///
/// ```text
/// z = 1 - 2u (sphere), z = 1 - u (hemisphere),   phi = 2 pi v
/// ```
///
/// The map preserves areas, not shapes: near the poles cells of the square become slivers. On the
/// hemisphere the edge u = 1 becomes the equator, where the pattern does not account for antipodes.
///
/// ```
/// use sphvar_samplers::{Domain, Hammersley, OnSphere, Purpose, Sampler, Streams};
/// let sampler = OnSphere::new(Hammersley::new(100)?, Domain::Hemisphere);
/// let set = sampler.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// assert!(set.len() == 100 && set.points.iter().all(|p| p.z >= 0.0));
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct OnSphere<P> {
    pattern: P,
    domain: Domain,
    is_octahedral: bool,
}

impl<P: SquareSampler> OnSphere<P> {
    /// Returns `pattern` on `domain`, by the map of Archimedes.
    #[must_use]
    pub fn new(pattern: P, domain: Domain) -> Self {
        Self { pattern, domain, is_octahedral: false }
    }

    /// Returns `pattern` on `domain` by [`OctahedralSphere`] or [`ConcentricHemisphere`].
    #[must_use]
    pub fn octahedral(pattern: P, domain: Domain) -> Self {
        Self { pattern, domain, is_octahedral: true }
    }

    fn direction(&self, [u, v]: [f64; 2]) -> DVec3 {
        match (self.is_octahedral, self.domain) {
            (false, Domain::Sphere) => archimedes(2.0 * u, TAU * v),
            (false, Domain::Hemisphere) => archimedes(u, TAU * v),
            (true, Domain::Sphere) => OctahedralSphere.sample([u, v]).point,
            (true, Domain::Hemisphere) => ConcentricHemisphere.sample([u, v]).point,
        }
    }
}

impl<P: SquareSampler> Sampler for OnSphere<P> {
    fn n_points(&self) -> usize {
        self.pattern.n_points()
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        if self.pattern.is_random() { SetDistribution::Random } else { SetDistribution::Fixed }
    }

    fn nominal_work(&self) -> f64 {
        self.pattern.nominal_work()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let mut square = PointSet::new(Vec::new());
        self.pattern.sample_watched(rng, &mut square, progress)?;
        set.start().extend(square.points.iter().map(|&point| self.direction(point)));
        set.weights.extend(square.weights);
        Ok(())
    }
}
