use crate::{
    Ensemble, Error, PointSet, Progress, Share, SquareSampler, Streams, shift, uniform_shift,
};

/// The ensemble of a sampler of the square: realization `i` is a function of (streams, i) alone.
///
/// With shifts, each realization is shifted modulo 1 by an independent uniform vector, which makes
/// the ensemble homogeneous on the torus: the condition under which a variance follows from the
/// spectrum. The shift is drawn from a separate stream, as the rotations of
/// [`Realizations`](crate::Realizations) are.
///
/// ```
/// use sphvar_samplers::{Purpose, SquarePattern, SquareRealizations, Streams};
/// let sampler = SquarePattern::WhiteSquare.build(48)?;
/// let ensemble = SquareRealizations::shifted(&*sampler, Streams::new(0, Purpose::Pattern, 48));
/// assert_eq!(ensemble.realize(5)?, ensemble.realize(5)?);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SquareRealizations<'a> {
    sampler: &'a dyn SquareSampler,
    streams: Streams,
    is_shifted: bool,
}

impl<'a> SquareRealizations<'a> {
    /// Returns the ensemble in which every realization has an independent uniform shift.
    #[must_use]
    pub fn shifted(sampler: &'a dyn SquareSampler, streams: Streams) -> Self {
        Self { sampler, streams, is_shifted: true }
    }

    /// Returns the ensemble as the sampler generates it.
    #[must_use]
    pub fn unshifted(sampler: &'a dyn SquareSampler, streams: Streams) -> Self {
        Self { sampler, streams, is_shifted: false }
    }

    /// Returns the sampler of the ensemble.
    #[must_use]
    pub fn sampler(&self) -> &'a dyn SquareSampler {
        self.sampler
    }

    /// Returns the shift of realization `index`; 0 without shifts.
    #[must_use]
    pub fn shift(&self, index: u64) -> [f64; 2] {
        if self.is_shifted {
            uniform_shift(&mut self.streams.randomization(index))
        } else {
            [0.0; 2]
        }
    }

    /// Replaces `set` by realization `index`, and ticks the sampler's nominal work.
    ///
    /// # Errors
    ///
    /// Those of [`SquareSampler::sample_watched`], and [`Error::Given`] if the sampler returns no
    /// points, points outside `[0, 1)^2`, numbers of weights and points that differ, or weights that
    /// are not finite or sum to 0.
    pub fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let share = Share::new(progress, self.sampler.nominal_work());
        self.sampler.sample_watched(&mut self.streams.realization(index), set, &share)?;
        let wrong = |reason| Error::Given { reason: format!("a realization {reason}") };
        set.check_realization().map_err(wrong)?;
        if self.is_shifted {
            shift(self.shift(index), &mut set.points);
        }
        Ok(share.finish()?)
    }

    /// Returns realization `index`.
    ///
    /// # Errors
    ///
    /// Those of [`SquareSampler::sample_into`].
    pub fn realize(&self, index: u64) -> Result<PointSet<[f64; 2]>, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.sampler.n_points()));
        self.realize_into(index, &mut set, &())?;
        Ok(set)
    }
}

impl Ensemble<[f64; 2]> for SquareRealizations<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Self::realize_into(self, index, set, progress)
    }
}
