use glam::DQuat;

use crate::ensemble::uniform_quaternion;
use crate::{Ensemble, Error, PointSet, Progress, RotationSampler, RotationSet, Streams};

/// The ensemble of a sampler of rotations: realization `i` is a function of (streams, i) alone.
///
/// With randomization, each realization is multiplied from the left by an independent uniform
/// rotation: each of its elements is then uniform, and the mean of a function over the set an
/// unbiased estimate of its mean over SO(3). That rotation comes from a separate stream, as in
/// [`Realizations`](crate::Realizations).
///
/// ```
/// use sphvar_samplers::{Purpose, RotationPattern, RotationRealizations, Streams};
/// let sampler = RotationPattern::SuperFibonacci.build(100)?;
/// let ensemble = RotationRealizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 100));
/// assert_eq!(ensemble.realize(5)?, ensemble.realize(5)?);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RotationRealizations<'a> {
    sampler: &'a dyn RotationSampler,
    streams: Streams,
    is_rotated: bool,
}

impl<'a> RotationRealizations<'a> {
    /// Returns the ensemble in which every realization is multiplied by an independent uniform
    /// rotation.
    #[must_use]
    pub fn rotated(sampler: &'a dyn RotationSampler, streams: Streams) -> Self {
        Self { sampler, streams, is_rotated: true }
    }

    /// Returns the ensemble as the sampler generates it.
    #[must_use]
    pub fn unrotated(sampler: &'a dyn RotationSampler, streams: Streams) -> Self {
        Self { sampler, streams, is_rotated: false }
    }

    /// Returns the rotation of realization `index`; the identity without randomization.
    #[must_use]
    pub fn rotation(&self, index: u64) -> DQuat {
        if self.is_rotated {
            uniform_quaternion(&mut self.streams.randomization(index))
        } else {
            DQuat::IDENTITY
        }
    }

    /// Replaces `set` by realization `index`, and ticks one unit of work for each rotation.
    ///
    /// # Errors
    ///
    /// Those of [`RotationSampler::sample_into`], and [`Error::Given`] if the sampler returns no
    /// rotations, quaternions that are not of length 1, numbers of weights and rotations that
    /// differ, or weights that are not finite or sum to 0.
    pub fn realize_into(
        &self,
        index: u64,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sampler.sample_into(&mut self.streams.realization(index), set, progress)?;
        let wrong = |reason| Error::Given { reason: format!("a realization {reason}") };
        set.check_realization().map_err(wrong)?;
        if self.is_rotated {
            let rotation = self.rotation(index);
            set.points.iter_mut().for_each(|q| *q = (rotation * *q).normalize());
        }
        Ok(progress.tick(set.len() as f64)?)
    }

    /// Returns realization `index`.
    ///
    /// # Errors
    ///
    /// Those of [`Self::realize_into`].
    pub fn realize(&self, index: u64) -> Result<RotationSet, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.sampler.n_points()));
        self.realize_into(index, &mut set, &())?;
        Ok(set)
    }
}

impl Ensemble<DQuat> for RotationRealizations<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Self::realize_into(self, index, set, progress)
    }
}
