/// The subject of a trial, in report order.
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
    /// Discrepancies, worst-case errors and energies of point sets.
    Quality,
    /// Quadrature weights and weighted sets.
    Weights,
    /// Least-squares fits of scattered values.
    Fits,
    /// Transforms on the square.
    Square,
    /// Maps from the square to directions.
    Warps,
}

impl Area {
    /// Every area.
    pub const ALL: [Self; 10] = [
        Self::Harmonics,
        Self::Indexing,
        Self::Transforms,
        Self::Spectra,
        Self::Predictions,
        Self::Quality,
        Self::Weights,
        Self::Fits,
        Self::Square,
        Self::Warps,
    ];

    /// Returns the name of the area in commands and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Harmonics => "harmonics",
            Self::Indexing => "indexing",
            Self::Transforms => "transforms",
            Self::Spectra => "spectra",
            Self::Predictions => "predictions",
            Self::Quality => "quality",
            Self::Weights => "weights",
            Self::Fits => "fits",
            Self::Square => "square",
            Self::Warps => "warps",
        }
    }
}
