use std::fmt;

use sphvar_samplers::Domain;

/// The mapping of point sets to directions at each shading point.
///
/// Sphere sets have M = 2N points, of which the visible half, about N, is used. Hemisphere sets
/// have N points, all of which are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DirectionMode {
    /// One sphere set as the pattern generates it, with the same world directions at every hit
    /// point. The errors of neighbouring pixels are similar, which is visible as bands and
    /// contours.
    Shared,
    /// One hemisphere set about the normal, rotated about it by a random angle at every hit point.
    Spun,
    /// Sphere sets, with a uniform random rotation at every hit point.
    Rotated,
    /// Hemisphere sets as antipodal (projective) sets, with a uniform random rotation at every hit
    /// point. Of each pair of antipodal directions the one above the surface is used.
    Antipodal,
    /// Like [`Self::Antipodal`], with a separate realization at every hit point.
    Fresh,
}

impl DirectionMode {
    /// All modes.
    pub const ALL: [Self; 5] =
        [Self::Shared, Self::Spun, Self::Rotated, Self::Antipodal, Self::Fresh];

    /// Returns the name: `shared`, `spun`, `rotated`, `antipodal` or `fresh`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Spun => "spun",
            Self::Rotated => "rotated",
            Self::Antipodal => "antipodal",
            Self::Fresh => "fresh",
        }
    }

    /// Returns the domain of the point sets.
    #[must_use]
    pub const fn domain(self) -> Domain {
        match self {
            Self::Shared | Self::Rotated => Domain::Sphere,
            Self::Spun | Self::Antipodal | Self::Fresh => Domain::Hemisphere,
        }
    }

    /// Returns the number of points of a set for `n_points` directions on the visible hemisphere:
    /// 2N for sphere sets.
    #[must_use]
    pub const fn set_points(self, n_points: usize) -> usize {
        match self.domain() {
            Domain::Sphere => n_points.saturating_mul(2),
            Domain::Hemisphere => n_points,
        }
    }
}

impl fmt::Display for DirectionMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
