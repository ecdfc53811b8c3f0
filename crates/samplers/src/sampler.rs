use std::fmt::Debug;

use rand::Rng;

use crate::hash::fnv1a;
use crate::{Domain, Error, PointSet, Progress, SetDistribution};

/// A generator of realizations of a pattern with a fixed number of points.
///
/// A sampler is immutable; all randomness comes from the generator that is passed in, so that a
/// realization is a function of the generator's state alone. A realization need not be
/// homogeneous by itself: users who need a rotation-invariant ensemble rotate it by
/// [`uniform_rotation`](crate::uniform_rotation), as [`Realizations`](crate::Realizations) does.
///
/// Three methods are required; the others describe the pattern and save computation. The trait is
/// object-safe: tools keep lists of `Box<dyn Sampler>`.
///
/// # Examples
///
/// ```
/// use rand::Rng;
/// use sphvar_samplers::{Domain, Error, PointSet, Sampler, uniform_rotation};
///
/// /// Pairs of antipodes of uniform directions.
/// #[derive(Debug)]
/// struct Pairs(usize);
///
/// impl Sampler for Pairs {
///     fn n_points(&self) -> usize {
///         2 * self.0
///     }
///
///     fn domain(&self) -> Domain {
///         Domain::Sphere
///     }
///
///     fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
///         let points = set.start();
///         for _ in 0..self.0 {
///             let p = uniform_rotation(rng).z_axis;
///             points.extend([p, -p]);
///         }
///         Ok(())
///     }
/// }
/// ```
pub trait Sampler: Debug + Send + Sync {
    /// Returns the number of points of every realization, at least 1; where it varies, the
    /// requested number.
    fn n_points(&self) -> usize;

    /// Returns the domain of the points.
    fn domain(&self) -> Domain;

    /// Replaces the content of `set` by one realization: unit vectors in `set.points`, with z >= 0
    /// on the hemisphere, and one weight each in `set.weights`, which stays empty for equal weights
    /// ([`PointSet::start`] clears both).
    ///
    /// The parameter is a whole buffer rather than a slice so that a loop over realizations
    /// allocates once and patterns with a random number of points have the same contract.
    ///
    /// # Errors
    ///
    /// [`Error::Infeasible`] if this realization cannot be completed; most patterns never fail.
    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error>;

    /// Samples as [`Self::sample_into`] does, with bit-identical results, and reports to
    /// `progress`. Implement it if a single realization may take long.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`], and [`Error::Stopped`].
    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        progress.tick(0.0)?;
        self.sample_into(rng, set)
    }

    /// Returns what is known about the distribution of the realizations. Default:
    /// [`SetDistribution::Random`].
    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Random
    }

    /// Returns the last degree t such that no realization has power at any degree `1 <= l <= t` of
    /// the domain (0 if there is none), for patterns that guarantee it; `None` for others.
    fn last_empty_degree(&self) -> Option<usize> {
        None
    }

    /// Returns the nominal work of a realization, in units of the work of a fast transform per
    /// point, about 60 ns of one core. Default: the number of points.
    ///
    /// The numbers of realizations of estimates follow from it, so changing a value changes
    /// published results. It need only be right to a factor of about 2.
    fn nominal_work(&self) -> f64 {
        self.n_points() as f64
    }

    /// Returns a number that distinguishes the random streams of this sampler from those of others
    /// in one run, for [`Streams::new`](crate::Streams::new). Default: a hash of the `Debug` text,
    /// which must show all parameters, and of the number of points.
    fn stream_group(&self) -> usize {
        fnv1a(format!("{self:?}").as_bytes()) as usize ^ self.n_points()
    }

    /// Returns the number of random streams with which realizations of fewer points are prefixes of
    /// those of more points, for [`Streams::new`](crate::Streams::new); `None` where prefixes are not
    /// sets of the pattern. Default: `None`.
    ///
    /// With [`Self::stream_group`], sets of different numbers of points are independent.
    fn sequence_group(&self) -> Option<usize> {
        None
    }

    /// Returns whether two realizations can differ by more than a rotation. `false` means that one
    /// realization determines the spectrum of the pattern.
    fn is_random(&self) -> bool {
        self.distribution().is_random()
    }

    /// Returns whether the points of a realization are independent of each other and uniformly
    /// distributed, so that moments of estimates follow from those of the integrand. `false` where
    /// that is not known.
    fn is_independent(&self) -> bool {
        self.n_points() == 1 || matches!(self.distribution(), SetDistribution::Independent)
    }

    /// Returns one realization.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`].
    fn sample(&self, rng: &mut dyn Rng) -> Result<PointSet, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.n_points()));
        self.sample_into(rng, &mut set)?;
        Ok(set)
    }
}
