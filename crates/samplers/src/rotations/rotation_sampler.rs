use std::fmt::Debug;

use glam::DQuat;
use rand::Rng;

use crate::hash::fnv1a;
use crate::of_pattern::OfPattern;
use crate::{Error, PointSet, PointSets, Progress, RotationGroup};

/// Rotations as unit quaternions, with or without weights. q and -q are the same rotation.
pub type RotationSet = PointSet<DQuat>;

/// A generator of sets of rotations with a fixed number of elements, as
/// [`Sampler`](crate::Sampler) is for directions.
///
/// # Examples
///
/// ```
/// use glam::DQuat;
/// use rand::Rng;
/// use sphvar_samplers::{Error, Progress, RotationSampler, RotationSet};
///
/// /// The half turns about the axes, and the identity.
/// #[derive(Debug)]
/// struct KleinGroup;
///
/// impl RotationSampler for KleinGroup {
///     fn n_points(&self) -> usize {
///         4
///     }
///
///     fn is_random(&self) -> bool {
///         false
///     }
///
///     fn sample_into(
///         &self,
///         _: &mut dyn Rng,
///         set: &mut RotationSet,
///         _: &dyn Progress,
///     ) -> Result<(), Error> {
///         let axes = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
///         set.start().extend(axes.map(DQuat::from_array));
///         set.points.push(DQuat::IDENTITY);
///         Ok(())
///     }
/// }
/// ```
pub trait RotationSampler: Debug + Send + Sync {
    /// Returns the number of rotations of every realization, at least 1.
    fn n_points(&self) -> usize;

    /// Replaces the content of `set` by one realization: unit quaternions in `set.points`, and one
    /// weight each in `set.weights`, which stays empty for equal weights ([`PointSet::start`]
    /// clears both).
    ///
    /// # Errors
    ///
    /// [`Error::Stopped`] if `progress` stops the work.
    fn sample_into(
        &self,
        rng: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error>;

    /// Returns whether two realizations can differ. Default: true.
    fn is_random(&self) -> bool {
        true
    }

    /// Returns a number that distinguishes the random streams of this sampler from those of others
    /// in one run, for [`Streams::new`](crate::Streams::new). Default: a hash of the `Debug` text,
    /// which must show all parameters, and of the number of rotations.
    fn stream_group(&self) -> usize {
        fnv1a(format!("{self:?}").as_bytes()) as usize ^ self.n_points()
    }

    /// Returns the number of random streams with which realizations of fewer rotations are prefixes of
    /// those of more, as [`Sampler::sequence_group`](crate::Sampler::sequence_group) does. Default:
    /// `None`.
    fn sequence_group(&self) -> Option<usize> {
        None
    }

    /// Returns one realization.
    ///
    /// # Errors
    ///
    /// Those of [`Self::sample_into`].
    fn sample(&self, rng: &mut dyn Rng) -> Result<RotationSet, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.n_points()));
        self.sample_into(rng, &mut set, &())?;
        Ok(set)
    }
}

impl RotationSampler for OfPattern<dyn RotationSampler> {
    fn n_points(&self) -> usize {
        self.sampler.n_points()
    }

    fn sample_into(
        &self,
        rng: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_into(rng, set, progress)
    }

    fn is_random(&self) -> bool {
        self.sampler.is_random()
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group
    }
}

/// Draws one of the sets uniformly.
impl RotationSampler for PointSets<RotationGroup> {
    /// Returns the mean number of rotations of the sets, rounded.
    fn n_points(&self) -> usize {
        self.mean_count()
    }

    fn sample_into(
        &self,
        rng: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        progress.tick(0.0)?;
        self.draw(rng, set);
        Ok(())
    }

    fn is_random(&self) -> bool {
        self.sets().len() > 1
    }

    fn stream_group(&self) -> usize {
        self.group()
    }
}
