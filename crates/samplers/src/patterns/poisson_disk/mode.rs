use std::fmt;

use sphvar_grammar::Choice;

/// The criterion by which a Poisson disk pattern is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiskMode {
    /// The set has exactly N points, whether or not more would fit.
    Exact,
    /// No further point fits: the set is maximal, and its number of points is random.
    Saturated,
}

impl DiskMode {
    /// Returns the mode's name: `exact` or `saturated`.
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
