/// How much work figures may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scale {
    /// All figures within some minutes: fewer realizations and points.
    Quick,
    /// The thesis's numbers of points and realizations.
    Full,
}

impl Scale {
    /// The name: `quick` or `full`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }

    /// Returns how the numbers of points and realizations compare with those of the thesis, for a page's header.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Quick => "Quick settings: fewer points and realizations than in the thesis.",
            Self::Full => "Full settings: the thesis's numbers of points and realizations.",
        }
    }

    /// One of two things.
    pub(crate) fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// What figures depend on besides the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Setting {
    /// How much work they may be.
    pub scale: Scale,
    /// The seed of all random streams.
    pub seed: u64,
}
