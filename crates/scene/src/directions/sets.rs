use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use rand::{Rng, RngExt};
use sphvar_samplers::{PointSet, Realizations, Sampler, Streams, uniform_rotation};

use crate::directions::frame::frame;
use crate::{DirectionMode, Error};

/// The sets of one render, and which of them, how turned, a hit point gets.
///
/// Made by [`DirectionPlan::prepare`](crate::DirectionPlan::prepare).
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
    /// Renders of one seed are fewer than this.
    pub const MAX_RENDERS: u64 = 1 << 24;
    /// Hit points of one render are fewer than this.
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

    /// The number of directions on the visible hemisphere; of halves of sphere sets the expected one.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> DirectionMode {
        self.mode
    }

    /// Replaces `dirs` by the directions of the hit point number `index` of a surface with this unit normal: unit
    /// vectors with `normal . dir >= 0`.
    ///
    /// # Errors
    /// [`Error::Sampler`] if a set of [`DirectionMode::Fresh`] cannot be completed.
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
                dirs.extend(self.sets[0].iter().filter(|d| is_kept(normal, **d)));
            }
            DirectionMode::Spun => {
                let spin = DMat3::from_rotation_z(TAU * stream().random::<f64>());
                let turn = frame(normal) * spin;
                dirs.extend(self.sets[0].iter().map(|&d| above(normal, turn * d)));
            }
            DirectionMode::Rotated => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let turn = uniform_rotation(&mut rng);
                // The half is chosen before turning: what is not kept costs a dot product.
                let back = turn.transpose() * normal;
                let kept = set.iter().filter(|d| is_kept(back, **d));
                dirs.extend(kept.map(|&d| turn * d));
            }
            DirectionMode::Projective => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let turn = uniform_rotation(&mut rng);
                dirs.extend(set.iter().map(|&d| above(normal, turn * d)));
            }
            DirectionMode::Fresh => {
                let sets = Realizations::rotated(&*self.sampler, self.streams);
                // The memory of the directions serves for the set.
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

    /// The nominal work of the set that each pixel makes for itself, if it does.
    pub(crate) fn own_work(&self) -> f64 {
        match self.mode {
            DirectionMode::Fresh => self.sampler.nominal_work(),
            _ => 0.0,
        }
    }

    fn choose(&self, rng: &mut dyn Rng) -> &[DVec3] {
        // One set needs no number.
        let k = if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) };
        &self.sets[k]
    }
}

/// Whether a direction of a sphere set belongs to the half above a surface. In its plane one of two opposite directions
/// does, and the other one to the half below, so that each direction is in one half.
fn is_kept(normal: DVec3, dir: DVec3) -> bool {
    let height = normal.dot(dir);
    height > 0.0 || (height == 0.0 && is_positive(dir) == is_positive(normal))
}

/// Whether the first coordinate that is not 0 is positive.
fn is_positive(dir: DVec3) -> bool {
    dir.to_array().into_iter().find(|x| *x != 0.0).is_some_and(|x| x > 0.0)
}

/// The end above the surface of the line along `dir`.
fn above(normal: DVec3, dir: DVec3) -> DVec3 {
    if normal.dot(dir) < 0.0 { -dir } else { dir }
}
