mod pencil;
mod qz;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler, SetDistribution,
};
use pencil::Pencil;
use qz::{Failure, Ratio};

const NAME: &str = "dpp";

/// The spherical ensemble, a determinantal point process: the eigenvalues of `A^-1 B`, with A and B
/// independent N x N matrices of independent complex normal entries, mapped to the sphere by
/// stereographic projection.
///
/// The points repel each other, and their distribution is invariant under rotations by itself. The
/// probability density of pairs at angle gamma, relative to independent points, and the mean power
/// are
///
/// ```text
/// g(gamma) = 1 - ((1 + cos gamma)/2)^{N-1}
/// P(l) = 1 - prod_{k=1}^{l} (N - k)/(N + k)       about l(l+1)/N for small l, 1 for l >= N
/// ```
///
/// On the hemisphere every point of the ensemble below the equator is replaced by its antipode. As
/// antipodal pairs the points are rotation-invariant too, and the power of even degrees is the same;
/// points that were nearly antipodal come close to each other.
///
/// A pencil of a triangular and a Hessenberg matrix with the same distribution of eigenvalues is
/// drawn directly, and the QZ algorithm determines the eigenvalues as ratios of two numbers, so that
/// no point of the sphere is special. The cost grows as N^3: about 4 s at N = 1000, with `16 N^2`
/// bytes of memory. The points are in the order in which the algorithm finds them, which is not
/// random.
///
/// ```
/// use sphvar_samplers::{Domain, Pattern, Purpose, Streams};
///
/// let ensemble = Pattern::Dpp.build(50, Domain::Sphere)?;
/// let points = ensemble.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0))?.points;
/// // The power of degree 1 is the square of the sum of the points over N, on average 2/(N + 1).
/// let z: f64 = points.iter().map(|p| p.z).sum();
/// assert!(points.len() == 50 && z.abs() < 4.0);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// Krishnapur 2009, Ann. Probab. 37, 314, for the ensemble and its correlations; Alishahi and Zamani
/// 2015, Electron. J. Probab. 20, 23, for its energies and discrepancy.
#[derive(Clone, Copy, Debug)]
pub struct SphericalEnsemble {
    n_points: usize,
    domain: Domain,
}

impl SphericalEnsemble {
    /// Nominal work per entry that a rotation visits, measured.
    const WORK_PER_ENTRY: f64 = 0.07;

    /// Returns the ensemble of `n_points` points, at least 1.
    pub(crate) fn new(n_points: usize, domain: Domain) -> Self {
        Self { n_points, domain }
    }

    fn infeasible(&self, reason: &str) -> Error {
        Error::Infeasible { pattern: NAME, n_points: self.n_points, reason: reason.to_owned() }
    }
}

impl Sampler for SphericalEnsemble {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::SphericalEnsemble
    }

    fn nominal_work(&self) -> f64 {
        Self::WORK_PER_ENTRY * qz::expected_entries(self.n_points)
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
        // A local generator: a `dyn` call for every number takes longer than the number.
        let mut own = ChaCha8Rng::from_rng(rng);
        let len = Pencil::n_entries(self.n_points);
        let mut entries = Vec::new();
        entries.try_reserve_exact(len).map_err(|_| Error::OutOfMemory {
            pattern: NAME,
            items: "entries of matrices",
            len,
            bytes_each: size_of::<pencil::Entry>(),
            remedy: "fewer points",
        })?;
        progress.tick(0.0)?;
        let mut pencil = Pencil::spherical(self.n_points, entries, &mut own);
        let tick = |entries: usize| progress.tick(Self::WORK_PER_ENTRY * entries as f64);
        let each = |ratio| points.push(self.domain.representative(direction(ratio)));
        qz::eigenvalues(&mut pencil, &tick, each).map_err(|failure| match failure {
            Failure::Stopped(stopped) => stopped.into(),
            Failure::NoConvergence => self.infeasible("the eigenvalues did not converge"),
        })
    }
}

/// Returns the direction whose stereographic projection from the north pole is `b/a`.
fn direction(Ratio { b, a }: Ratio) -> DVec3 {
    // Scaled, so that squares neither overflow nor underflow.
    let scale = b.norm().max(a.norm());
    if !(scale > 0.0 && scale.is_finite()) {
        return DVec3::Z;
    }
    let (b, a) = (b / scale, a / scale);
    let xy = 2.0 * b * a.conj();
    DVec3::new(xy.re, xy.im, b.norm_sqr() - a.norm_sqr()).normalize()
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::CUBIC,
            low_degrees: "l(l+1)/N",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Krishnapur 2009; Alishahi and Zamani 2015",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(SphericalEnsemble::new(n_points, domain)))
    }
}
