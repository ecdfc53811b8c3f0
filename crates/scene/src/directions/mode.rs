use std::fmt;

use sphvar_samplers::Domain;

/// How the sets of a pattern become the directions of a hit point.
///
/// Sphere sets have M = 2N points, of which the half is kept that the surface sees, about N; hemisphere sets
/// have N points, all of which are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DirectionMode {
    /// One sphere set as the pattern makes it, the same directions in the world at every hit point. Errors of
    /// neighbouring pixels are alike, which is seen as bands and contours.
    Shared,
    /// One hemisphere set about the normal, turned about it by a random angle at every hit point.
    Spun,
    /// Sphere sets, turned at every hit point by a uniform rotation.
    Rotated,
    /// Hemisphere sets as sets of lines (the projective plane), turned at every hit point by a uniform rotation;
    /// of each line the end above the surface is taken.
    Projective,
    /// As [`Self::Projective`], with a realization of its own at every hit point.
    Fresh,
}

impl DirectionMode {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Shared, Self::Spun, Self::Rotated, Self::Projective, Self::Fresh];

    /// The name: `shared`, `spun`, `rotated`, `projective` or `fresh`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Spun => "spun",
            Self::Rotated => "rotated",
            Self::Projective => "projective",
            Self::Fresh => "fresh",
        }
    }

    /// Where the sets live.
    #[must_use]
    pub const fn domain(self) -> Domain {
        match self {
            Self::Shared | Self::Rotated => Domain::Sphere,
            Self::Spun | Self::Projective | Self::Fresh => Domain::Hemisphere,
        }
    }

    /// The number of points of a set for `n_points` directions on the visible hemisphere: 2N of sphere sets.
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
