use rand::Rng;
use sphvar_grammar::{Declaration, Parametric, Range};

use super::white_noise;
use crate::definition::Definition;
use crate::optimization::RieszEnergy;
use crate::{CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler, count};

/// The number of pairs a point whose direct sum takes as long as the split energy of a large set.
const SPLIT_WORK: f64 = 2000.0;

/// White noise after a number of steps that minimize the Riesz energy of exponent s, or the
/// logarithmic energy for s = 0 (Hardin and Saff 2004); see [`riesz_energy`](crate::riesz_energy).
///
/// s = 1 is Thomson's problem. Steps are those of a limited-memory BFGS method, none of which
/// increases the energy. The default number of steps takes tens of points to a local minimum and a
/// thousand points to within 1e-5 of its energy for s = 1, 2e-3 for s = 4. There are many minima,
/// so realizations differ by more than a rotation from about N = 16.
///
/// The distribution is invariant under rotations, so every single point is uniform. The cost of a
/// step is N^2 pairs below 2048 points, twice that on the hemisphere, and about linear in N above,
/// where energies are split into near and far parts (see [`riesz_energy`](crate::riesz_energy));
/// it is sometimes a multiple where a step is shortened. Non-integer exponents cost several times
/// more. The near part runs on all threads; points do not depend on their number. Results for
/// integer s > 0 and N < 2048 are the same on every machine; the others depend on the platform's
/// `pow` and `log`, and on its registers.
///
/// ```
/// use sphvar_samplers::{Domain, Purpose, Riesz, Sampler, Streams, riesz_energy};
/// let thomson = Riesz::new(12, Domain::Sphere, Riesz::DEFAULT_S, Riesz::DEFAULT_ITERATIONS)?;
/// let set = thomson.sample(&mut Streams::new(0, Purpose::Pattern, 12).realization(0))?;
/// // The icosahedron.
/// assert!((riesz_energy(&set.points, Domain::Sphere, 1.0) - 49.165253058).abs() < 1e-8);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Riesz {
    n: u32,
    domain: Domain,
    s: f64,
    iterations: u32,
}

impl Riesz {
    /// The Coulomb energy.
    pub const DEFAULT_S: f64 = 1.0;

    /// The default number of steps.
    pub const DEFAULT_ITERATIONS: u32 = 100;

    /// Returns the pattern of `n_points` points for the exponent `s` after `iterations` steps, 0 of
    /// which leave white noise.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX` and `s` in [0, 4].
    pub fn new(n_points: usize, domain: Domain, s: f64, iterations: u32) -> Result<Self, Error> {
        if !(0.0..=4.0).contains(&s) {
            return Err(Error::Parameter {
                name: "the Riesz exponent s",
                range: "in [0, 4]",
                got: s,
            });
        }
        Ok(Self { n: count::checked(n_points)?, domain, s, iterations })
    }
}

impl Sampler for Riesz {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn nominal_work(&self) -> f64 {
        let n = f64::from(self.n);
        let pairs = n * n.min(SPLIT_WORK);
        6.5 * pairs * f64::from(self.iterations) / f64::from(Self::DEFAULT_ITERATIONS)
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        points.extend((0..self.n).map(|_| white_noise::uniform_direction(self.domain, rng)));
        let step = self.nominal_work() / f64::from(self.iterations.max(1));
        let energy = RieszEnergy::new(self.domain, self.s);
        energy.descend(points, self.iterations, &|| progress.tick(step))?;
        for p in points {
            *p = self.domain.representative(*p);
        }
        Ok(())
    }
}

/// Parameters of the pattern [`Riesz`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RieszParameters {
    /// The exponent.
    pub s: f64,
    /// Number of steps.
    pub iterations: u32,
}

impl RieszParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { s: Riesz::DEFAULT_S, iterations: Riesz::DEFAULT_ITERATIONS };
}

impl Default for RieszParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for RieszParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.number("s", Range::closed(0.0, 4.0), "exponent; 0: the logarithmic energy", &mut self.s);
        let range = [0, i64::from(u32::MAX)];
        d.integer("iterations", range, "steps downhill", &mut self.iterations);
    }
}

impl Definition for RieszParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC.times("per step"),
            low_degrees: "1e-5 l at N = 1024, where the steps reach",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Hardin and Saff 2004",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(Riesz::new(n_points, domain, self.s, self.iterations)?))
    }
}
