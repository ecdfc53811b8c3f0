use glam::{DMat3, DVec3};

use crate::{Error, PointSet, Progress, Sampler, Share, Streams, rotate, uniform_rotation};

/// A numbered collection of point sets: the realizations of a sampler, or given sets. `Ensemble` is
/// one of directions, `Ensemble<[f64; 2]>` one of points of the square.
pub trait Ensemble<P = DVec3>: Sync {
    /// Replaces `set` by set `index`.
    ///
    /// # Errors
    ///
    /// [`Error`] if the set cannot be generated, [`Error::Stopped`] if `progress` stopped the work.
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet<P>,
        progress: &dyn Progress,
    ) -> Result<(), Error>;
}

/// The ensemble of a sampler: realization `i` is a function of (streams, i) alone.
///
/// With rotation, each realization is rotated by an independent uniform rotation, which makes the
/// ensemble homogeneous: the condition under which a variance follows from the spectrum.
/// The rotation is drawn from a separate stream. The unrotated ensemble of the
/// same streams therefore has the same sets before rotation, and points that two samplers share,
/// such as the beginning of a sequence, still agree after it.
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
    /// Returns the ensemble in which every realization has an independent uniform rotation.
    #[must_use]
    pub fn rotated(sampler: &'a dyn Sampler, streams: Streams) -> Self {
        Self { sampler, streams, rotated: true }
    }

    /// Returns the ensemble as the sampler generates it.
    #[must_use]
    pub fn unrotated(sampler: &'a dyn Sampler, streams: Streams) -> Self {
        Self { sampler, streams, rotated: false }
    }

    /// Returns the sampler of the ensemble.
    #[must_use]
    pub fn sampler(&self) -> &'a dyn Sampler {
        self.sampler
    }

    /// Returns the rotation of realization `index`; the identity without rotation.
    #[must_use]
    pub fn rotation(&self, index: u64) -> DMat3 {
        if self.rotated {
            uniform_rotation(&mut self.streams.randomization(index))
        } else {
            DMat3::IDENTITY
        }
    }

    /// Replaces `set` by realization `index`, and ticks the sampler's nominal work.
    ///
    /// # Errors
    ///
    /// Those of [`Sampler::sample_watched`], and [`Error::Given`] if the sampler returns no points,
    /// points that are not unit vectors, numbers of weights and points that differ, or weights that
    /// are not finite or sum to 0.
    pub fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let share = Share::new(progress, self.sampler.nominal_work());
        self.sampler.sample_watched(&mut self.streams.realization(index), set, &share)?;
        let wrong = |reason| Error::Given { reason: format!("a realization {reason}") };
        set.check_realization().map_err(wrong)?;
        if self.rotated {
            rotate(self.rotation(index), self.sampler.domain(), &mut set.points);
        }
        Ok(share.finish()?)
    }

    /// Returns realization `index`.
    ///
    /// # Errors
    ///
    /// Those of [`Sampler::sample_into`].
    pub fn realize(&self, index: u64) -> Result<PointSet, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.sampler.n_points()));
        self.realize_into(index, &mut set, &())?;
        Ok(set)
    }
}

impl Ensemble for Realizations<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Self::realize_into(self, index, set, progress)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::Rng;

    use crate::{Domain, Error, PointSet, Purpose, Realizations, Sampler, Streams, WhiteNoise};

    /// A faulty user-defined sampler causes an error, never a result.
    #[test]
    fn an_invalid_realization_is_an_error() {
        #[derive(Debug)]
        struct Faulty(PointSet);
        impl Sampler for Faulty {
            fn n_points(&self) -> usize {
                2
            }
            fn domain(&self) -> Domain {
                Domain::Sphere
            }
            fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
                set.clone_from(&self.0);
                Ok(())
            }
        }
        let x = DVec3::X;
        let cases: [(Vec<DVec3>, &[f64], &str); 8] = [
            (vec![], &[], "no points"),
            (vec![x, x * 2.0], &[], "not of length 1 at point 1"),
            (vec![DVec3::ZERO, x], &[], "not of length 1 at point 0"),
            (vec![x, DVec3::NAN], &[], "not of length 1 at point 1"),
            (vec![x, x], &[1.0], "2 points and 1 weights"),
            (vec![x, x], &[1.0, f64::INFINITY], "not finite at point 1"),
            (vec![x, x], &[0.0, 0.0], "sum is 0"),
            (vec![x, x], &[1e200, -1e200], "sum is 0"),
        ];
        for (points, weights, expected) in cases {
            let sampler = Faulty(PointSet { points, weights: weights.to_vec() });
            let streams = Streams::new(0, Purpose::Pattern, 0);
            for sets in [
                Realizations::rotated(&sampler, streams),
                Realizations::unrotated(&sampler, streams),
            ] {
                let error = sets.realize(0).unwrap_err().to_string();
                assert!(error.contains(expected), "{error}");
            }
        }
    }

    /// The first points of a sequence do not depend on the number of points, rotated or not.
    #[test]
    fn prefixes_do_not_depend_on_the_number_of_points() {
        let streams = Streams::new(3, Purpose::Pattern, 0);
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let (few, many) = (WhiteNoise::new(70, domain), WhiteNoise::new(500, domain));
            for index in [0, 1, 77] {
                let of = |sampler| Realizations::rotated(sampler, streams).realize(index).unwrap();
                assert_eq!(of(&few).points, of(&many).points[..70]);
            }
        }
    }
}
