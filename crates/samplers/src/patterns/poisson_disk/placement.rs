use std::fmt;

use sphvar_grammar::Choice;

/// The method by which the points of a Poisson disk pattern are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiskPlacement {
    /// Uniformly in the free region, with disks of one radius:
    /// [`PoissonDisk`](crate::PoissonDisk).
    DartThrowing,
    /// On the boundaries of previous disks: [`BoundaryPoissonDisk`](crate::BoundaryPoissonDisk).
    Boundary,
    /// Uniformly in the free region, with disks of decreasing radius:
    /// [`DecreasingPoissonDisk`](crate::DecreasingPoissonDisk).
    Decreasing,
}

impl DiskPlacement {
    /// Returns the method's name: `dart-throwing`, `boundary` or `decreasing`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DartThrowing => "dart-throwing",
            Self::Boundary => "boundary",
            Self::Decreasing => "decreasing",
        }
    }
}

impl Choice for DiskPlacement {
    const CHOICES: &'static [(&'static str, Self)] = &[
        (Self::DartThrowing.name(), Self::DartThrowing),
        (Self::Boundary.name(), Self::Boundary),
        (Self::Decreasing.name(), Self::Decreasing),
    ];
}

impl fmt::Display for DiskPlacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
