use rand::Rng;
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Rate, Square, SquareDistribution, SquareSampler,
    count,
};

/// 2^128 divided by the plastic number rho, the real root of `x^3 = x + 1`, and by its square,
/// rounded down: the steps in turns.
const STEPS: [u128; 2] =
    [0xC13F_A9A9_02A6_328F_434F_F71B_2D97_724B, 0x91E1_0DA5_C79E_7B1C_D438_A0A8_E6C9_C0FC];

/// The sequence R2 (Roberts 2018), a sequence of Kronecker whose steps generalize the golden ratio:
/// point j, from 1, is
///
/// ```text
/// ( 1/2 + j/rho, 1/2 + j/rho^2  mod 1 ),   rho = 1.3247..., the plastic number.
/// ```
///
/// The coordinates are computed in fixed point, so they are exact to rounding for any j.
#[derive(Clone, Copy, Debug)]
pub struct R2 {
    n: u32,
}

impl R2 {
    /// Returns the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for R2 {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        set.start().extend((1..=self.n).map(point));
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<Square> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Roberts 2018",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(R2::new(n_points)?))
    }
}

/// Returns point `j`.
fn point(j: u32) -> [f64; 2] {
    STEPS.map(|step| {
        let turns = u128::from(j).wrapping_mul(step).wrapping_add(1 << 127);
        (turns >> 75) as f64 * 2f64.powi(-53)
    })
}

#[cfg(test)]
mod tests {
    use super::point;

    #[test]
    fn the_steps_are_the_powers_of_the_inverse_plastic_number() {
        // The fixed point of x = (1 + x)^(1/3).
        let rho = (0..60).fold(1.0_f64, |x, _| (1.0 + x).cbrt());
        for j in 0..2000_u32 {
            let got = point(j);
            for (d, x) in got.into_iter().enumerate() {
                let steps = f64::from(j) / if d == 0 { rho } else { rho * rho };
                let off = (x - 0.5 - steps).rem_euclid(1.0);
                // The plain product is accurate to j EPSILON.
                let bound = 4.0 * f64::EPSILON * (f64::from(j) + 1.0);
                assert!(off.min(1.0 - off) < bound, "j = {j}: {got:?}");
            }
        }
        // 1/rho + 1/rho^3 = 1/rho^2 + 1/rho^3 + ... : the steps satisfy x^3 + x^2 = 1.
        let [x, y] = point(1).map(|x| (x - 0.5).rem_euclid(1.0));
        assert!((x * y + y - 1.0).abs() < 4.0 * f64::EPSILON && (x * x - y).abs() < 1e-15);
    }
}
