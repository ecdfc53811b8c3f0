use crate::WarpedText;

/// The reason why a variance cannot be predicted or measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    #[error("{name} must be {range}, got {got}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// The valid range in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
    /// The integrand's energies are unknown, or it cannot be evaluated.
    #[error(transparent)]
    Integrand(#[from] sphvar_integrands::Error),
    /// The domain of a sampler differs from that of the integral.
    #[error("the points are on the {got}, but the integral is over the {expected}")]
    OtherDomain {
        /// The domain of the integral.
        expected: sphvar_sh::Domain,
        /// The domain of the points.
        got: sphvar_sh::Domain,
    },
    /// The prediction would reflect the energy beyond the spectrum instead of the pattern.
    #[error(
        "a spectrum to degree {lmax} cannot predict the variance of {n_points} points: their power settles at degree \
         {settled}, and the integrand has energy in between; the minimum sufficient degree is {min_lmax}"
    )]
    Unsettled {
        /// The requested degree.
        lmax: usize,
        /// The least sufficient degree.
        min_lmax: usize,
        /// The degree at which the pattern's power is about 1.
        settled: usize,
        /// The number of points.
        n_points: usize,
    },
    /// A heuristic of a single density, which has no weights.
    #[error("{text}: heuristic= is for a sum of warps; remove it")]
    Heuristic {
        /// The text of the pattern.
        text: String,
    },
    /// Parameters of a warp among those of the pattern.
    #[error("the parameters of a warp belong inside its quotes: {quoted}")]
    Unquoted {
        /// The text with the quotes.
        quoted: WarpedText,
    },
    /// A number of points that the warps of a pattern cannot share.
    #[error(
        "{pattern} has no sets of {requested} points: shared between its warps, the nearest valid counts are \
         {counts:?}, {nearest} together"
    )]
    Total {
        /// The pattern.
        pattern: String,
        /// The requested number of points.
        requested: usize,
        /// The number of points of each warp at the next valid count.
        counts: Vec<usize>,
        /// The next valid count.
        nearest: usize,
    },
    /// A prediction for other densities than those of the pattern.
    #[error("{pattern} has {expected} warps, but the integrand was divided by {got} densities")]
    Strategies {
        /// The pattern.
        pattern: String,
        /// The number of its warps.
        expected: usize,
        /// The number of densities of the integrand.
        got: usize,
    },
    /// The spectrum of a pattern cannot be computed.
    #[error(transparent)]
    Spectrum(#[from] sphvar_spectrum::Error),
}

impl From<sphvar_samplers::Error> for Error {
    fn from(error: sphvar_samplers::Error) -> Self {
        Self::Spectrum(error.into())
    }
}

impl From<sphvar_samplers::Stopped> for Error {
    fn from(stopped: sphvar_samplers::Stopped) -> Self {
        Self::Spectrum(stopped.into())
    }
}
