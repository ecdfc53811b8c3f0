use std::fmt::Debug;

use rand::Rng;

use crate::hash::fnv1a;
use crate::{Error, PointSet, Progress, SquareDistribution};

/// A generator of realizations of a pattern of the unit square with a fixed number of points.
///
/// As for a [`Sampler`](crate::Sampler), a realization is a function of the generator's state
/// alone. A realization need not be homogeneous by itself: users who need an ensemble that is
/// invariant under shifts modulo 1 shift it by [`uniform_shift`](crate::uniform_shift), as
/// [`SquareRealizations`](crate::SquareRealizations) does.
///
/// [`OnSphere`](crate::OnSphere) and [`CosineHemisphere`](crate::CosineHemisphere) map the points to
/// directions. Two methods are required.
///
/// # Examples
///
/// ```
/// use rand::{Rng, RngExt};
/// use sphvar_samplers::{Error, PointSet, SquareSampler};
///
/// /// Pairs of points that are half a turn apart in both coordinates.
/// #[derive(Debug)]
/// struct Pairs(usize);
///
/// impl SquareSampler for Pairs {
///     fn n_points(&self) -> usize {
///         2 * self.0
///     }
///
///     fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
///         let points = set.start();
///         for _ in 0..self.0 {
///             let p: [f64; 2] = rng.random();
///             points.extend([p, p.map(|x| (x + 0.5) % 1.0)]);
///         }
///         Ok(())
///     }
/// }
/// ```
pub trait SquareSampler: Debug + Send + Sync {
    /// Returns the number of points of every realization, at least 1; where it varies, the
    /// requested number.
    fn n_points(&self) -> usize;

    /// Replaces the content of `set` by one realization: pairs `[u, v]` in [0, 1) in `set.points`,
    /// and one weight each in `set.weights`, which stays empty for equal weights
    /// ([`PointSet::start`] clears both).
    ///
    /// # Errors
    ///
    /// [`Error::Infeasible`] if this realization cannot be completed; most patterns never fail.
    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error>;

    /// Samples as [`Self::sample_into`] does, with bit-identical results, and reports to
    /// `progress`. Implement it if a single realization may take long.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`], and [`Error::Stopped`].
    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        progress.tick(0.0)?;
        self.sample_into(rng, set)
    }

    /// Returns what is known about the distribution of the realizations. Default:
    /// [`SquareDistribution::Random`].
    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Random
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

    /// Returns whether two realizations can differ by more than a shift. `false` means that one
    /// realization determines the spectrum of the pattern.
    fn is_random(&self) -> bool {
        self.distribution().is_random()
    }

    /// Returns whether the points of a realization are independent of each other and uniformly
    /// distributed, so that moments of estimates follow from those of the integrand. `false` where
    /// that is not known.
    fn is_independent(&self) -> bool {
        self.n_points() == 1 || matches!(self.distribution(), SquareDistribution::Independent)
    }

    /// Returns one realization.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`].
    fn sample(&self, rng: &mut dyn Rng) -> Result<PointSet<[f64; 2]>, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.n_points()));
        self.sample_into(rng, &mut set)?;
        Ok(set)
    }
}

impl<P: SquareSampler + ?Sized> SquareSampler for Box<P> {
    fn n_points(&self) -> usize {
        (**self).n_points()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        (**self).sample_into(rng, set)
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        (**self).sample_watched(rng, set, progress)
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        (**self).distribution()
    }

    fn nominal_work(&self) -> f64 {
        (**self).nominal_work()
    }

    fn stream_group(&self) -> usize {
        (**self).stream_group()
    }

    fn sequence_group(&self) -> Option<usize> {
        (**self).sequence_group()
    }

    fn is_random(&self) -> bool {
        (**self).is_random()
    }

    fn is_independent(&self) -> bool {
        (**self).is_independent()
    }
}
