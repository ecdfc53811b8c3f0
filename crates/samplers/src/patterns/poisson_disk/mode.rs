use std::fmt;

use sphvar_grammar::Choice;

/// When a Poisson disk pattern is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiskMode {
    /// With exactly N points, whether or not there is room for more.
    Exact,
    /// When there is no room for another point: the set is maximal, and N is what comes out.
    Saturated,
}

impl DiskMode {
    /// The mode's name: `exact` or `saturated`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Saturated => "saturated",
        }
    }
}

impl Choice for DiskMode {
    const CHOICES: &'static [(&'static str, Self)] =
        &[(Self::Exact.name(), Self::Exact), (Self::Saturated.name(), Self::Saturated)];
}

impl fmt::Display for DiskMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
