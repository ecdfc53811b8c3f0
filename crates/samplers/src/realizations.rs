use glam::DVec3;
use rand::Rng;

use crate::{Error, Sampler, Streams, rotate, uniform_rotation};

/// The ensemble of a sampler: realization `i` is a function of (streams, i) alone.
///
/// With rotation, each realization is turned by a uniform rotation of its own, which makes the
/// ensemble homogeneous: the condition under which a variance follows from the spectrum
/// (`docs/theory.md`). The rotation is drawn after the points, so the unturned ensemble of the
/// same streams is the same sets before turning.
///
/// ```
/// use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
/// let sampler = Pattern::Jittered.build(48, Domain::Sphere)?;
/// let ensemble = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 48));
/// assert_eq!(ensemble.realize(5)?, ensemble.realize(5)?);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Realizations<'a> {
    sampler: &'a dyn Sampler,
    streams: Streams,
    rotated: bool,
}

impl<'a> Realizations<'a> {
    /// The ensemble in which every realization is turned by its own uniform rotation.
    #[must_use]
    pub fn rotated(sampler: &'a dyn Sampler, streams: Streams) -> Self {
        Self { sampler, streams, rotated: true }
    }

    /// The ensemble as the sampler makes it.
    #[must_use]
    pub fn unrotated(sampler: &'a dyn Sampler, streams: Streams) -> Self {
        Self { sampler, streams, rotated: false }
    }

    /// The sampler of the ensemble.
    #[must_use]
    pub fn sampler(&self) -> &'a dyn Sampler {
        self.sampler
    }

    /// Replaces `points` by realization `index`.
    ///
    /// # Errors
    ///
    /// Those of [`Sampler::sample_into`].
    pub fn realize_into(&self, index: u64, points: &mut Vec<DVec3>) -> Result<(), Error> {
        let rng: &mut dyn Rng = &mut self.streams.realization(index);
        self.sampler.sample_into(rng, points)?;
        if self.rotated {
            rotate(uniform_rotation(rng), self.sampler.domain(), points);
        }
        Ok(())
    }

    /// Realization `index` in a vector of its own.
    ///
    /// # Errors
    ///
    /// Those of [`Sampler::sample_into`].
    pub fn realize(&self, index: u64) -> Result<Vec<DVec3>, Error> {
        let mut points = Vec::with_capacity(self.sampler.n_points());
        self.realize_into(index, &mut points)?;
        Ok(points)
    }
}
