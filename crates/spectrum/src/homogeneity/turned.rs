use std::fmt;
use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use rand::Rng;
use sphvar_samplers::{Sampler, Streams, rotate};

use crate::{Error, PointSets};

/// How a rotation is drawn, such as [`uniform_rotation`](sphvar_samplers::uniform_rotation).
pub type RotationLaw = fn(&mut dyn Rng) -> DMat3;

/// The ensemble of a sampler, each set turned by a rotation of its own that is remembered.
///
/// With [`uniform_rotation`](sphvar_samplers::uniform_rotation) the sets are those of
/// [`Realizations::rotated`](sphvar_samplers::Realizations::rotated) to the bit.
pub struct TurnedSets<'a> {
    sampler: &'a dyn Sampler,
    streams: Streams,
    law: RotationLaw,
    rotations: Vec<OnceLock<DMat3>>,
}

impl<'a> TurnedSets<'a> {
    /// The ensemble of `count` sets.
    #[must_use]
    pub fn new(sampler: &'a dyn Sampler, streams: Streams, count: usize, law: RotationLaw) -> Self {
        Self { sampler, streams, law, rotations: vec![OnceLock::new(); count] }
    }

    /// The rotations of the sets that have been made so far, in the order of their numbers.
    #[must_use]
    pub fn rotations(&self) -> Vec<DMat3> {
        self.rotations.iter().filter_map(OnceLock::get).copied().collect()
    }
}

impl PointSets for TurnedSets<'_> {
    fn realize_into(
        &self,
        index: u64,
        points: &mut Vec<DVec3>,
        weights: &mut Vec<f64>,
    ) -> Result<(), Error> {
        weights.clear();
        let rng: &mut dyn Rng = &mut self.streams.realization(index);
        self.sampler.sample_into(rng, points)?;
        let rotation = (self.law)(rng);
        let slot = usize::try_from(index).ok().and_then(|i| self.rotations.get(i));
        if let Some(slot) = slot {
            // A set that is made again has the same rotation again.
            slot.get_or_init(|| rotation);
        }
        rotate(rotation, self.sampler.domain(), points);
        Ok(())
    }
}

impl fmt::Debug for TurnedSets<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.rotations.len();
        f.debug_struct("TurnedSets")
            .field("sampler", &self.sampler)
            .field("count", &count)
            .finish_non_exhaustive()
    }
}
