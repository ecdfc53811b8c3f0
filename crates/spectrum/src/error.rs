/// Why a spectrum cannot be computed or merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The transform cannot be built.
    #[error(transparent)]
    Transform(#[from] sphvar_sht::Error),
    /// A realization of the pattern cannot be made.
    #[error(transparent)]
    Sampler(#[from] sphvar_samplers::Error),
    /// Two accumulators do not belong to the same ensemble.
    #[error("cannot merge spectra of different {what}: {left} and {right}")]
    Mismatch {
        /// What differs.
        what: &'static str,
        /// Its value on the left.
        left: String,
        /// Its value on the right.
        right: String,
    },
    /// An ensemble of no realizations has no mean.
    #[error("a spectrum needs at least 1 realization, got 0")]
    NoRealizations,
    /// A setting is out of its range.
    #[error("{what} must be {expected}, got {got}")]
    Setting {
        /// Which one.
        what: &'static str,
        /// What it can be.
        expected: &'static str,
        /// What it was.
        got: f64,
    },
}

impl From<sphvar_samplers::Stopped> for Error {
    fn from(stopped: sphvar_samplers::Stopped) -> Self {
        Self::Sampler(stopped.into())
    }
}
