/// What a trial is about, in the order in which reports show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Area {
    /// Associated Legendre functions and spherical harmonics of single arguments.
    Harmonics,
    /// Directions to HEALPix pixels and back.
    Indexing,
    /// Transforms of scattered points.
    Transforms,
    /// Angular power spectra of ensembles.
    Spectra,
    /// Predicted variances.
    Predictions,
}

impl Area {
    /// Every area.
    pub const ALL: [Self; 5] =
        [Self::Harmonics, Self::Indexing, Self::Transforms, Self::Spectra, Self::Predictions];

    /// The name by which commands and files know the area.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Harmonics => "harmonics",
            Self::Indexing => "indexing",
            Self::Transforms => "transforms",
            Self::Spectra => "spectra",
            Self::Predictions => "predictions",
        }
    }
}
