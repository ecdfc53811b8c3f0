/// Error of computing or merging a spectrum.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The transform cannot be constructed.
    #[error(transparent)]
    Transform(#[from] sphvar_sht::Error),
    /// The transform of points of the square cannot be constructed or computed.
    #[error(transparent)]
    SquareTransform(#[from] sphvar_nufft::Error),
    /// There are too many frequencies for an error of each.
    #[error("errors of all frequencies are kept to kmax = {max}, got kmax = {kmax}")]
    Frequencies {
        /// The requested maximum frequency.
        kmax: usize,
        /// The largest supported value.
        max: usize,
    },
    /// The sampler cannot generate a realization, or the work was stopped.
    #[error(transparent)]
    Sampler(#[from] sphvar_samplers::Error),
    /// The accumulators have different parameters.
    #[error("cannot merge spectra of different {what}: {left} and {right}")]
    Mismatch {
        /// The parameter that differs.
        what: &'static str,
        /// Its value on the left.
        left: String,
        /// Its value on the right.
        right: String,
    },
    /// The ensemble has no realizations.
    #[error("a spectrum needs at least 1 realization, got 0")]
    NoRealizations,
    /// Points are so close together that the sum over near pairs would take hours.
    #[error(
        "the set has about {pairs:.0e} pairs of near points, more than the {max:.0e} that can be \
         summed; merge points that almost coincide (identical points are merged already)"
    )]
    NearPairs {
        /// The estimated number of pairs.
        pairs: f64,
        /// The largest number that is summed.
        max: f64,
    },
    /// A setting is out of range.
    #[error("{what} must be {expected}, got {got}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// The valid range.
        expected: &'static str,
        /// The value given.
        got: f64,
    },
}

impl From<sphvar_samplers::Stopped> for Error {
    fn from(stopped: sphvar_samplers::Stopped) -> Self {
        Self::Sampler(stopped.into())
    }
}

/// Checks that a parameter of two accumulators is equal.
///
/// # Errors
///
/// [`Error::Mismatch`] if it is not.
pub(crate) fn check_equal<T: PartialEq + std::fmt::Debug>(
    what: &'static str,
    left: &T,
    right: &T,
) -> Result<(), Error> {
    if left == right {
        return Ok(());
    }
    Err(Error::Mismatch { what, left: format!("{left:?}"), right: format!("{right:?}") })
}
