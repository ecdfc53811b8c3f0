/// The reason why a figure cannot be produced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A text does not name a figure.
    #[error("unknown figure \"{name}\"; valid: {valid}")]
    UnknownFigure {
        /// The text.
        name: String,
        /// The numbers of all figures, separated by commas.
        valid: String,
    },
    /// A pattern cannot be built.
    #[error(transparent)]
    Sampler(#[from] sphvar_samplers::Error),
    /// A spectrum cannot be computed.
    #[error(transparent)]
    Spectrum(#[from] sphvar_spectrum::Error),
    /// An integrand cannot be evaluated.
    #[error(transparent)]
    Integrand(#[from] sphvar_integrands::Error),
    /// A variance cannot be computed.
    #[error(transparent)]
    Variance(#[from] sphvar_variance::Error),
    /// A bound cannot be checked.
    #[error(transparent)]
    Bounds(#[from] sphvar_bounds::Error),
    /// A picture cannot be rendered.
    #[error(transparent)]
    Scene(#[from] sphvar_scene::Error),
    /// A harmonic cannot be computed.
    #[error(transparent)]
    Harmonics(#[from] sphvar_sh::Error),
    /// A HEALPix cell does not exist.
    #[error(transparent)]
    Healpix(#[from] sphvar_healpix::Error),
    /// The results do not contain a job of the figure.
    #[error("the results lack \"{key}\": run all jobs of the figure first")]
    Missing {
        /// Its key.
        key: String,
    },
    /// Bytes are not those of a finished piece.
    #[error("the finished piece \"{key}\" is damaged or of another version")]
    Piece {
        /// The key of the piece.
        key: String,
    },
    /// A finished piece cannot be stored.
    #[error("a finished piece cannot be kept: {reason}")]
    Store {
        /// The error of the store.
        reason: String,
    },
}
