use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use rand::{Rng, RngExt};
use sphvar_samplers::{PointSet, Realizations, Sampler, Streams, uniform_rotation};

use crate::directions::frame::frame;
use crate::{DirectionMode, Error};

/// The sets of one render, with the choice and rotation of the set at each hit point.
///
/// Created by [`DirectionPlan::prepare`](crate::DirectionPlan::prepare).
#[derive(Debug)]
pub struct DirectionSets {
    mode: DirectionMode,
    n_points: usize,
    sets: Vec<Box<[DVec3]>>,
    sampler: Box<dyn Sampler>,
    streams: Streams,
    first_stream: u64,
}

impl DirectionSets {
    /// The exclusive upper limit of the renders of one seed.
    pub const MAX_RENDERS: u64 = 1 << 24;
    /// The exclusive upper limit of the hit points of one render.
    pub const MAX_HITS: u64 = u64::MAX / Self::MAX_RENDERS;

    pub(crate) fn new(
        mode: DirectionMode,
        n_points: usize,
        sets: Vec<Box<[DVec3]>>,
        sampler: Box<dyn Sampler>,
        streams: Streams,
        render: u64,
    ) -> Self {
        let first_stream = render * (Self::MAX_HITS + 1);
        Self { mode, n_points, sets, sampler, streams, first_stream }
    }

    /// Returns the number of directions on the visible hemisphere; for halves of sphere sets, the
    /// expected number.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the mode.
    #[must_use]
    pub fn mode(&self) -> DirectionMode {
        self.mode
    }

    /// Replaces `dirs` by the directions of hit point `index` on a surface with this unit normal:
    /// unit vectors with `normal . dir >= 0`.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if a set of [`DirectionMode::Fresh`] cannot be generated.
    pub fn directions_into(
        &self,
        normal: DVec3,
        index: u64,
        dirs: &mut Vec<DVec3>,
    ) -> Result<(), Error> {
        let stream = || self.streams.realization(self.first_stream + index);
        dirs.clear();
        match self.mode {
            DirectionMode::Shared => {
                dirs.extend(self.sets[0].iter().filter(|d| is_visible(normal, **d)));
            }
            DirectionMode::Spun => {
                let spin = DMat3::from_rotation_z(TAU * stream().random::<f64>());
                let rotation = frame(normal) * spin;
                dirs.extend(self.sets[0].iter().map(|&d| above(normal, rotation * d)));
            }
            DirectionMode::Rotated => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let rotation = uniform_rotation(&mut rng);
                // The half is chosen before the rotation, so a discarded direction costs only a dot
                // product.
                let back = rotation.transpose() * normal;
                let visible = set.iter().filter(|d| is_visible(back, **d));
                dirs.extend(visible.map(|&d| rotation * d));
            }
            DirectionMode::Antipodal => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let rotation = uniform_rotation(&mut rng);
                dirs.extend(set.iter().map(|&d| above(normal, rotation * d)));
            }
            DirectionMode::Fresh => {
                let sets = Realizations::rotated(&*self.sampler, self.streams);
                // Reuses the memory of the directions for the set.
                let mut set = PointSet::new(std::mem::take(dirs));
                sets.realize_into(self.first_stream + index, &mut set, &())?;
                *dirs = set.points;
                for dir in dirs {
                    *dir = above(normal, *dir);
                }
            }
        }
        Ok(())
    }

    /// Returns the nominal work of the set that each pixel generates separately; 0 in other modes.
    pub(crate) fn own_work(&self) -> f64 {
        match self.mode {
            DirectionMode::Fresh => self.sampler.nominal_work(),
            _ => 0.0,
        }
    }

    fn choose(&self, rng: &mut dyn Rng) -> &[DVec3] {
        // A single set needs no random number.
        let k = if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) };
        &self.sets[k]
    }
}

/// Returns whether a direction of a sphere set belongs to the half above a surface. Of two opposite
/// directions in its plane, one belongs to the upper half and one to the lower half, so each
/// direction is in exactly one half.
fn is_visible(normal: DVec3, dir: DVec3) -> bool {
    let height = normal.dot(dir);
    height > 0.0 || (height == 0.0 && is_positive(dir) == is_positive(normal))
}

/// Returns whether the first nonzero coordinate is positive.
fn is_positive(dir: DVec3) -> bool {
    dir.to_array().into_iter().find(|x| *x != 0.0).is_some_and(|x| x > 0.0)
}

/// Returns whichever of `dir` and `-dir` is above the surface.
fn above(normal: DVec3, dir: DVec3) -> DVec3 {
    if normal.dot(dir) < 0.0 { -dir } else { dir }
}
