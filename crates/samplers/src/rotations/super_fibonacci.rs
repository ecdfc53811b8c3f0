use std::f64::consts::TAU;

use glam::DQuat;
use rand::Rng;
use sphvar_grammar::Parametric;

use super::POINTS_PER_TICK;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, Progress, Rate, RotationGroup, RotationSampler, RotationSet,
    count,
};

/// 2^128 divided by 2 sqrt(2) and by 2 psi, rounded down: half the steps of the two angles in turns.
const HALF_STEPS: [u128; 2] =
    [0x5A82_7999_FCEF_3242_2CBE_C4D9_BAA5_5F4F, 0x5374_9CE6_C8DD_0D0A_C146_EDB2_9455_0EFA];

/// The super-Fibonacci spiral of Alexa 2022 (algorithm 1): rotation i of N is the quaternion
///
/// ```text
/// (w, x, y, z) = (r sin a, r cos a, R sin b, R cos b),   s = i + 1/2,
/// r = sqrt(s/N),  R = sqrt(1 - s/N),  a = 2 pi s/sqrt(2),  b = 2 pi s/psi
/// ```
///
/// with psi = 1.533751..., the positive root of `psi^4 = psi + 4`. The angles are computed in fixed
/// point modulo one turn, so they are exact to rounding for any i. Sets of different N have no
/// elements in common; the pattern is deterministic.
///
/// # References
///
/// M. Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)", CVPR 2022.
#[derive(Clone, Copy, Debug)]
pub struct SuperFibonacci {
    n: u32,
}

impl SuperFibonacci {
    /// Returns the pattern of `n_points` rotations.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl RotationSampler for SuperFibonacci {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn is_random(&self) -> bool {
        false
    }

    fn sample_into(
        &self,
        _: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let rotations = set.start();
        let n = f64::from(self.n);
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            let s = f64::from(i) + 0.5;
            let [(sin_a, cos_a), (sin_b, cos_b)] =
                HALF_STEPS.map(|half| (TAU * turns(i, half)).sin_cos());
            let (r, big_r) = ((s / n).sqrt(), ((n - s) / n).sqrt());
            rotations.push(DQuat::from_xyzw(r * cos_a, big_r * sin_b, big_r * cos_b, r * sin_a));
        }
        Ok(())
    }
}

/// Returns the fractional part, in [0, 1) turns, of `2i + 1` half steps.
fn turns(i: u32, half_step: u128) -> f64 {
    let turns = (2 * u128::from(i) + 1).wrapping_mul(half_step);
    (turns >> 75) as f64 * 2f64.powi(-53)
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<RotationGroup> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::Depends,
            is_extensible: false,
            source: "Alexa 2022",
        }
    }

    fn build(&self, n_points: usize, _: RotationGroup) -> Result<Box<dyn RotationSampler>, Error> {
        Ok(Box::new(SuperFibonacci::new(n_points)?))
    }
}

#[cfg(test)]
mod tests {
    use super::{HALF_STEPS, turns};

    #[test]
    fn steps_are_those_of_the_roots() {
        // Newton's method from a rounded root of x^4 = x + 4.
        let mut psi = 1.5_f64;
        for _ in 0..10 {
            psi -= (psi.powi(4) - psi - 4.0) / (4.0 * psi.powi(3) - 1.0);
        }
        for (half, root) in HALF_STEPS.into_iter().zip([2f64.sqrt(), psi]) {
            for i in (0..3000).chain([100_000, 1_000_000]) {
                let plain = (f64::from(i) + 0.5) / root % 1.0;
                let off = (turns(i, half) - plain).abs();
                let off = off.min(1.0 - off);
                assert!(off <= 2.0 * f64::EPSILON * (f64::from(i) + 1.0), "i = {i}: {off}");
            }
        }
    }
}
