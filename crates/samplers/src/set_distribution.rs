use sphvar_healpix::Nside;

use crate::{EqualArea, PointSet};

/// The known properties of the distribution of a sampler's realizations, up to rotation. They
/// decide whether spectra are computed in closed form or estimated.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SetDistribution<'a> {
    /// No property that determines a spectrum.
    Random,
    /// Independent uniform points.
    Independent,
    /// One uniform point in each of N strata of equal area, independent of the others.
    Stratified(Strata<'a>),
    /// The spherical ensemble of N points, a determinantal point process that is invariant under
    /// rotations; on the hemisphere with the antipodes of points below the equator.
    SphericalEnsemble,
    /// Always the same set, up to rotation: one realization determines the spectrum of the pattern.
    Fixed,
    /// One of the given sets, drawn uniformly.
    OneOf(&'a [PointSet]),
}

/// A partition of the domain into strata of equal area.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Strata<'a> {
    /// The cells of HEALPix; on the hemisphere those of half the faces, one of each pair of
    /// antipodal cells.
    Healpix(Nside),
    /// The regions of Leopardi 2006.
    EqualArea(&'a EqualArea),
}

impl SetDistribution<'_> {
    /// Returns whether two realizations can differ by more than a rotation.
    #[must_use]
    pub fn is_random(&self) -> bool {
        match self {
            Self::Fixed => false,
            Self::OneOf(sets) => sets.len() > 1,
            Self::Random | Self::Independent | Self::Stratified(_) | Self::SphericalEnsemble => {
                true
            }
        }
    }
}
