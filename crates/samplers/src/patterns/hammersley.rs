use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::square::radical_inverse;
use crate::{
    CostOrder, Domain, Error, OnSphere, PatternFacts, Rate, Sampler, SquarePattern, count,
};

/// The Hammersley set of N points in base 2 (Hammersley 1960), shifted at random.
///
/// Point i is `((i + 1/2)/N + s, phi_2(i) + t)` modulo 1 with one uniform pair (s, t) for the whole
/// set (Cranley and Patterson 1976): every point is uniform in the square. On the sphere the
/// heights are thus an arithmetic progression, and the shift of the second coordinate is a rotation
/// about the axis.
#[derive(Clone, Copy, Debug)]
pub struct Hammersley {
    n: u32,
}

impl Hammersley {
    /// Returns the pattern of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquarePattern for Hammersley {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn is_random(&self) -> bool {
        true
    }

    fn fill_into(&self, rng: &mut dyn Rng, points: &mut Vec<[f64; 2]>) -> Result<(), Error> {
        let [s, t]: [f64; 2] = rng.random();
        let n = f64::from(self.n);
        points.clear();
        points.extend((0..self.n).map(|i| {
            [
                radical_inverse::shifted((f64::from(i) + 0.5) / n, s),
                radical_inverse::shifted(radical_inverse::base_2(i), t),
            ]
        }));
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-3.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Hammersley 1960; Cranley and Patterson 1976",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(OnSphere::new(Hammersley::new(n_points)?, domain)))
    }
}
