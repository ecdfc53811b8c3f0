use std::fmt::Display;

use glam::DQuat;

use crate::of_pattern::OfPattern;
use crate::space::internal;
use crate::{Point, PointSets, RotationSampler, Space};

/// The rotation group SO(3); its elements are unit quaternions, of which q and -q are the same
/// rotation.
///
/// A rotation is active: it maps a vector v to q v q^-1. The distance of two rotations is the angle
/// of the rotation from one to the other, `2 acos |q . p|`, from 0 to pi; it does not change
/// when both are multiplied by a third from the left or from the right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct RotationGroup;

impl Space for RotationGroup {}
impl Point for DQuat {}

impl Display for RotationGroup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad("rotation group")
    }
}

impl internal::Space for RotationGroup {
    type Point = DQuat;
    type Sampler = dyn RotationSampler;

    fn boxed(sets: PointSets<Self>) -> Box<dyn RotationSampler> {
        Box::new(sets)
    }

    fn with_groups(
        sampler: Box<dyn RotationSampler>,
        group: usize,
        sequence_group: Option<usize>,
    ) -> Box<dyn RotationSampler> {
        Box::new(OfPattern::new(sampler, group, sequence_group))
    }

    /// Returns the unit quaternion along a quaternion of any length.
    fn located(self, point: DQuat) -> Option<DQuat> {
        let largest = point.to_array().into_iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        let unit = (point * (1.0 / largest)).normalize();
        unit.is_finite().then_some(unit)
    }
}

impl internal::Point for DQuat {
    const INVALID: &'static str = "a quaternion that is not of length 1";
    const NOWHERE: &'static str = "no rotation";

    fn is_valid(&self) -> bool {
        (self.length_squared() - 1.0).abs() <= 2e-9
    }

    fn coordinates(&self) -> impl Iterator<Item = f64> {
        self.to_array().into_iter()
    }
}
