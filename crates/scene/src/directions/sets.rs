use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use rand::{Rng, RngExt};
use sphvar_samplers::{
    Domain, PointSet, Realizations, Sampler, SetDistribution, Streams, uniform_rotation,
};

use crate::directions::frame::frame;
use crate::{DirectionMode, Directions, Error, SetWeight, ShadingPoint};

/// The sets of one render, with the choice and rotation of the set at each hit point.
///
/// Created by [`DirectionPlan::prepare`](crate::DirectionPlan::prepare).
#[derive(Debug)]
pub struct DirectionSets {
    mode: DirectionMode,
    n_points: usize,
    sets: Vec<PointSet>,
    /// The expected weight of the visible directions of each set.
    visible_weights: Vec<f64>,
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
        mut sets: Vec<PointSet>,
        sampler: Box<dyn Sampler>,
        streams: Streams,
        render: u64,
    ) -> Self {
        let first_stream = render * (Self::MAX_HITS + 1);
        sets.iter_mut().for_each(PointSet::normalize_weights);
        let is_given = matches!(sampler.distribution(), SetDistribution::OneOf(_));
        let visible_weight = |set: &PointSet| visible_weight(set, mode, n_points, is_given);
        let visible_weights = sets.iter().map(visible_weight).collect();
        Self { mode, n_points, sets, visible_weights, sampler, streams, first_stream }
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

    /// Replaces the content of `directions` by the directions of hit point `index` on a surface with
    /// this unit normal: unit vectors with `normal . dir >= 0`, with the weights of their set if it
    /// has any. Returns the expected weight of the visible directions, by which the estimator
    /// `unbiased` divides: for sphere sets half the sum of all weights, for hemisphere sets the sum.
    ///
    /// Weights are scaled by a power of two, so that none exceeds 1 in magnitude.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if a set of [`DirectionMode::Fresh`] cannot be generated.
    pub fn directions_into(
        &self,
        normal: DVec3,
        index: u64,
        directions: &mut PointSet,
    ) -> Result<f64, Error> {
        let stream = || self.streams.realization(self.first_stream + index);
        directions.start();
        let chosen = match self.mode {
            DirectionMode::Shared => {
                extend_visible(directions, &self.sets[0], normal, |dir| dir);
                0
            }
            DirectionMode::Spun => {
                let spin = DMat3::from_rotation_z(TAU * stream().random::<f64>());
                let rotation = frame(normal) * spin;
                extend_all(directions, &self.sets[0], |dir| above(normal, rotation * dir));
                0
            }
            DirectionMode::Rotated => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let rotation = uniform_rotation(&mut rng);
                // The half is chosen before the rotation, so a discarded direction costs only a dot
                // product.
                let back = rotation.transpose() * normal;
                extend_visible(directions, &self.sets[set], back, |dir| rotation * dir);
                set
            }
            DirectionMode::Antipodal => {
                let mut rng = stream();
                let set = self.choose(&mut rng);
                let rotation = uniform_rotation(&mut rng);
                extend_all(directions, &self.sets[set], |dir| above(normal, rotation * dir));
                set
            }
            DirectionMode::Fresh => {
                let sets = Realizations::rotated(&*self.sampler, self.streams);
                sets.realize_into(self.first_stream + index, directions, &())?;
                directions.normalize_weights();
                for dir in &mut directions.points {
                    *dir = above(normal, *dir);
                }
                let is_given = matches!(self.sampler.distribution(), SetDistribution::OneOf(_));
                return Ok(visible_weight(directions, self.mode, self.n_points, is_given));
            }
        };
        Ok(self.visible_weights[chosen])
    }

    /// Returns the index of a random set.
    fn choose(&self, rng: &mut dyn Rng) -> usize {
        // A single set needs no random number.
        if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) }
    }
}

impl Directions for DirectionSets {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn directions_into(
        &self,
        at: &ShadingPoint<'_>,
        index: u64,
        directions: &mut PointSet,
    ) -> Result<SetWeight, Error> {
        let expected = Self::directions_into(self, at.normal(), index, directions)?;
        Ok(SetWeight { visible: directions.weight_sums().0, expected })
    }

    fn is_uniform(&self) -> bool {
        true
    }

    /// Returns the nominal work of the set that each pixel generates separately; 0 in other modes.
    fn own_work(&self) -> f64 {
        match self.mode {
            DirectionMode::Fresh => self.sampler.nominal_work(),
            _ => 0.0,
        }
    }
}

/// Returns the expected weight of the visible directions of a set: the requested number for patterns
/// with equal weights, whose realizations may differ in their numbers.
fn visible_weight(set: &PointSet, mode: DirectionMode, n_points: usize, is_given: bool) -> f64 {
    if set.weights.is_empty() && !is_given {
        return n_points as f64;
    }
    let sum = set.weight_sums().0;
    match mode.domain() {
        Domain::Sphere => 0.5 * sum,
        Domain::Hemisphere => sum,
    }
}

/// Appends the mapped directions of `set` that are visible from a surface with this normal.
fn extend_visible(
    directions: &mut PointSet,
    set: &PointSet,
    normal: DVec3,
    map: impl Fn(DVec3) -> DVec3,
) {
    let visible = |dir: &&DVec3| is_visible(normal, **dir);
    directions.points.extend(set.points.iter().filter(visible).map(|&dir| map(dir)));
    let weights = set.points.iter().zip(&set.weights).filter(|(dir, _)| visible(dir));
    directions.weights.extend(weights.map(|(_, &weight)| weight));
}

/// Appends all mapped directions of `set`.
fn extend_all(directions: &mut PointSet, set: &PointSet, map: impl Fn(DVec3) -> DVec3) {
    directions.points.extend(set.points.iter().map(|&dir| map(dir)));
    directions.weights.extend(&set.weights);
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
