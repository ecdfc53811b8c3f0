//! The spaces on which prefixes are predicted.

use std::fmt::Debug;

use sphvar_samplers::{
    Domain, PointSet, Progress, Realizations, Square, SquareRealizations, Streams,
};

use sphvar_sh::Frequencies;
use sphvar_spectrum::Resolution;

use super::prefix::{Prefix, truncated};
use super::sphere_variances::SphereVariances;
use super::square_variances::SquareVariances;
use crate::space::{Distribution, IntegrationSpace, prefix_frequencies};
use crate::{Error, PredictorOn};

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

    /// Returns the variances of all prefixes of the sets of a sampler for the integrand of a
    /// predictor.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn prefix_variances(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Box<dyn PrefixVariances<Self::Point>>, Error>;

    /// Returns how far the spectrum of a prefix is computed for the errors of tails and energies.
    ///
    /// # Errors
    ///
    /// Returns the errors of the integrand's energies.
    fn checkpoint_extent(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Self::Extent, Error>;

    /// Returns the realizations of a sampler without rotation or shift.
    fn as_drawn(sampler: Self::SamplerRef<'_>, streams: Streams) -> Self::Realizations<'_>;
}

/// The variances of integrating one function with the prefixes of any set, randomly rotated or
/// shifted.
pub trait PrefixVariances<P>: Debug + Send + Sync {
    /// Returns the variance of the prefix with each of `counts` points, in increasing order, and
    /// the part of it beyond the known energies; NaN where the weights sum to 0. Ticks
    /// [`Self::work`].
    ///
    /// # Errors
    ///
    /// Returns an error if `progress` stops the work.
    fn of_set(
        &self,
        set: &PointSet<P>,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<Vec<[f64; 2]>, Error>;

    /// Makes tables that all sets share. Ticks [`Self::preparation_work`] when it is called first. The
    /// default implementation makes none.
    ///
    /// # Errors
    ///
    /// Returns an error if `progress` stops the work.
    fn prepare(&self, _progress: &dyn Progress) -> Result<(), Error> {
        Ok(())
    }

    /// Returns the nominal work of [`Self::prepare`]. The default implementation returns 0.
    fn preparation_work(&self) -> f64 {
        0.0
    }

    /// Returns whether there is energy beyond that of the known bands.
    fn has_tail(&self) -> bool;

    /// Returns whether the energies are estimates with errors.
    fn has_estimates(&self) -> bool;

    /// Returns the nominal work of the prefixes of a set up to `n_points`.
    fn work(&self, n_points: usize) -> f64;
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

    fn prefix_variances(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Box<dyn PrefixVariances<Self::Point>>, Error> {
        let last = predictor.prefix_degree(sampler)?;
        let energy = predictor.energy_to(last)?;
        Ok(Box::new(SphereVariances::new(energy, last, Self::n_points(sampler))?))
    }

    /// The means over windows of degrees deviate less from 1 at higher degrees, so spectra to 8
    /// sqrt(N) suffice.
    fn checkpoint_extent(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<usize, Error> {
        let extent = predictor.extent(predictor.budget(), sampler)?;
        let natural = Resolution::natural_degree(sampler.n_points());
        let is_requested = predictor.options().lmax.is_some();
        Ok(if is_requested { extent } else { extent.min(2 * natural) })
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

    fn prefix_variances(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Box<dyn PrefixVariances<Self::Point>>, Error> {
        let frequencies = prefix_frequencies(predictor, sampler)?;
        let energy = predictor.energies_to(&frequencies)?;
        Ok(Box::new(SquareVariances::new(energy, &frequencies)))
    }

    fn checkpoint_extent(
        predictor: &mut PredictorOn<'_, Self>,
        sampler: Self::SamplerRef<'_>,
    ) -> Result<Frequencies, Error> {
        prefix_frequencies(predictor, sampler)
    }

    fn as_drawn(sampler: Self::SamplerRef<'_>, streams: Streams) -> SquareRealizations<'_> {
        SquareRealizations::unshifted(sampler, streams)
    }
}

/// Returns whether a prefix estimates nothing, because the weights of one of its sets sum to 0.
pub(super) fn is_void<S: IntegrationSpace>(prefix: S::SamplerRef<'_>) -> bool {
    S::given_sets(prefix).iter().any(|set| set.n_effective() <= 0.0)
}

/// Returns whether the sets of a sampler are homogeneous without rotation or shift.
pub(super) fn is_homogeneous<S: IntegrationSpace>(sampler: S::SamplerRef<'_>) -> bool {
    matches!(S::distribution(sampler), Distribution::Independent)
}
