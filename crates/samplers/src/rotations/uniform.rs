use rand::Rng;
use sphvar_grammar::Parametric;

use super::POINTS_PER_TICK;
use crate::definition::Definition;
use crate::ensemble::uniform_quaternion;
use crate::{
    CostOrder, Error, PatternFacts, Progress, Rate, RotationGroup, RotationSampler, RotationSet,
    count,
};

/// Independent rotations, each from Haar measure (Shoemake 1992); see
/// [`uniform_rotation`](crate::uniform_rotation).
#[derive(Clone, Copy, Debug)]
pub struct UniformRotations {
    n: u32,
}

impl UniformRotations {
    /// Returns the sampler of `n_points` rotations.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl RotationSampler for UniformRotations {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn sample_into(
        &self,
        rng: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let rotations = set.start();
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            rotations.push(uniform_quaternion(rng));
        }
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<RotationGroup> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "1",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: true,
            source: "Shoemake 1992",
        }
    }

    fn build(&self, n_points: usize, _: RotationGroup) -> Result<Box<dyn RotationSampler>, Error> {
        Ok(Box::new(UniformRotations::new(n_points)?))
    }
}
