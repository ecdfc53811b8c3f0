/// The amount of work per figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scale {
    /// All figures within some minutes: fewer realizations and points.
    Quick,
    /// The numbers of points and realizations of the thesis.
    Full,
}

impl Scale {
    /// Returns the name: `quick` or `full`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }

    /// Returns how the numbers of points and realizations compare with those of the thesis, for a
    /// page's header.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Quick => "Quick settings: fewer points and realizations than in the thesis.",
            Self::Full => "Full settings: the thesis's numbers of points and realizations.",
        }
    }

    /// Returns one of two values.
    pub(crate) fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// The parameters of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Setting {
    /// The amount of work.
    pub scale: Scale,
    /// The seed of all random streams.
    pub seed: u64,
}
