use std::fmt;

/// The side of the spectrum on which a profile lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The spectrum lies on or below the profile.
    Upper,
    /// The spectrum lies on or above the profile.
    Lower,
}

impl Side {
    /// Returns the name, `upper` or `lower`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Upper => "upper",
            Self::Lower => "lower",
        }
    }

    /// Returns the other side.
    pub(crate) const fn opposite(self) -> Self {
        match self {
            Self::Upper => Self::Lower,
            Self::Lower => Self::Upper,
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
