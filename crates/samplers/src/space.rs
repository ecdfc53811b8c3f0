use std::fmt::{Debug, Display};

use glam::DVec3;

use crate::of_pattern::OfPattern;
use crate::{Domain, PointSets, Sampler, SquareSampler};

/// Where the points of a pattern lie: on a [`Domain`] of directions or in the unit [`Square`].
///
/// `S::Point` is the type of its points, `S::Sampler` that of its samplers: [`DVec3`] and
/// `dyn Sampler`, or `[f64; 2]` and `dyn SquareSampler`.
pub trait Space: Copy + Debug + Display + PartialEq + Send + Sync + internal::Space {}

/// The unit square `[0, 1)^2` whose opposite edges are identified, a torus; coordinates are in
/// turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Square;

/// A point of a [`Space`]: a direction, or `[u, v]` in the square.
pub trait Point: Copy + Debug + Default + PartialEq + Send + Sync + internal::Point {}

impl Space for Domain {}
impl Space for Square {}
impl Point for DVec3 {}
impl Point for [f64; 2] {}

impl Display for Square {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad("square")
    }
}

/// What the crate needs to know about spaces and points, sealed.
#[expect(unnameable_types, reason = "sealed traits")]
pub(crate) mod internal {
    pub trait Space: Sized + 'static {
        /// The points of the space.
        type Point: crate::Point;
        /// The trait object of the samplers of the space.
        type Sampler: ?Sized;

        /// Returns given sets as a sampler.
        fn boxed(sets: crate::PointSets<Self>) -> Box<Self::Sampler>
        where
            Self: crate::Space;

        /// Returns the sampler with these numbers of the random streams of its sets and of its
        /// sequence.
        fn with_groups(
            sampler: Box<Self::Sampler>,
            group: usize,
            sequence_group: Option<usize>,
        ) -> Box<Self::Sampler>;

        /// Returns the point of the space that a given point stands for, if there is one.
        fn located(self, point: Self::Point) -> Option<Self::Point>;
    }

    pub trait Point: 'static {
        /// What a set with an invalid point has, for messages.
        const INVALID: &'static str;
        /// What a set with a point that stands for none has, for messages.
        const NOWHERE: &'static str;

        /// Returns whether a realization may have this point.
        fn is_valid(&self) -> bool;

        /// Returns the coordinates.
        fn coordinates(&self) -> impl Iterator<Item = f64>;
    }
}

impl internal::Space for Domain {
    type Point = DVec3;
    type Sampler = dyn Sampler;

    fn boxed(sets: PointSets<Self>) -> Box<dyn Sampler> {
        Box::new(sets)
    }

    fn with_groups(
        sampler: Box<dyn Sampler>,
        group: usize,
        sequence_group: Option<usize>,
    ) -> Box<dyn Sampler> {
        Box::new(OfPattern::new(sampler, group, sequence_group))
    }

    /// Returns the unit vector along a vector of any length; on the hemisphere, the representative
    /// of its antipodal pair.
    fn located(self, point: DVec3) -> Option<DVec3> {
        // Unit vectors stay bit-identical.
        let is_unit = (point.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON;
        let along = || (point / point.abs().max_element()).try_normalize();
        let unit = if is_unit { Some(point) } else { along() };
        unit.map(|unit| self.representative(unit))
    }
}

impl internal::Space for Square {
    type Point = [f64; 2];
    type Sampler = dyn SquareSampler;

    fn boxed(sets: PointSets<Self>) -> Box<dyn SquareSampler> {
        Box::new(sets)
    }

    fn with_groups(
        sampler: Box<dyn SquareSampler>,
        group: usize,
        sequence_group: Option<usize>,
    ) -> Box<dyn SquareSampler> {
        Box::new(OfPattern::new(sampler, group, sequence_group))
    }

    fn located(self, point: [f64; 2]) -> Option<[f64; 2]> {
        internal::Point::is_valid(&point).then_some(point)
    }
}

impl internal::Point for DVec3 {
    const INVALID: &'static str = "a vector that is not of length 1";
    const NOWHERE: &'static str = "no direction";

    fn is_valid(&self) -> bool {
        (self.length_squared() - 1.0).abs() <= 2e-9
    }

    fn coordinates(&self) -> impl Iterator<Item = f64> {
        self.to_array().into_iter()
    }
}

impl internal::Point for [f64; 2] {
    const INVALID: &'static str = "coordinates outside [0, 1)";
    const NOWHERE: &'static str = Self::INVALID;

    fn is_valid(&self) -> bool {
        self.iter().all(|x| (0.0..1.0).contains(x))
    }

    fn coordinates(&self) -> impl Iterator<Item = f64> {
        self.iter().copied()
    }
}
