//! The spaces on which prefixes are predicted.

use sphvar_samplers::{Domain, Realizations, Square, SquareRealizations, Streams};

use super::prefix::{Prefix, truncated};
use crate::Error;
use crate::space::{Distribution, IntegrationSpace};

/// A space on which every prefix of a sequence is predicted and measured: the sphere, the
/// hemisphere and the unit square.
///
/// It is not meant to be implemented outside this crate.
pub trait ProgressiveSpace: IntegrationSpace {
    /// Calls `f` with the sampler of the first `n_points` points of each set, whose random streams
    /// have the number `group`.
    ///
    /// # Errors
    ///
    /// Returns the errors of `f`.
    fn with_prefix<T>(
        sampler: Self::SamplerRef<'_>,
        n_points: usize,
        group: usize,
        f: impl FnOnce(Self::SamplerRef<'_>) -> Result<T, Error>,
    ) -> Result<T, Error>;

    /// Returns the realizations of a sampler without rotation or shift.
    fn as_drawn(sampler: Self::SamplerRef<'_>, streams: Streams) -> Self::Realizations<'_>;
}

impl ProgressiveSpace for Domain {
    fn with_prefix<T>(
        sampler: Self::SamplerRef<'_>,
        n_points: usize,
        group: usize,
        f: impl FnOnce(Self::SamplerRef<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let sets = truncated(Self::given_sets(sampler), n_points);
        f(&Prefix { sampler, n_points, group, sets })
    }

    fn as_drawn(sampler: Self::SamplerRef<'_>, streams: Streams) -> Realizations<'_> {
        Realizations::unrotated(sampler, streams)
    }
}

impl ProgressiveSpace for Square {
    fn with_prefix<T>(
        sampler: Self::SamplerRef<'_>,
        n_points: usize,
        group: usize,
        f: impl FnOnce(Self::SamplerRef<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let sets = truncated(Self::given_sets(sampler), n_points);
        f(&Prefix { sampler, n_points, group, sets })
    }

    fn as_drawn(sampler: Self::SamplerRef<'_>, streams: Streams) -> SquareRealizations<'_> {
        SquareRealizations::unshifted(sampler, streams)
    }
}

/// Returns whether the sets of a sampler are homogeneous without rotation or shift.
pub(super) fn is_homogeneous<S: IntegrationSpace>(sampler: S::SamplerRef<'_>) -> bool {
    matches!(S::distribution(sampler), Distribution::Independent)
}
