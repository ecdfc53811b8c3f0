use glam::DVec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_healpix::{Cell, Nside};

use crate::patterns::healpix::strata;
use crate::{
    Domain, Error, PointSet, Progress, Sampler, SetDistribution, Share, SquareSampler, count,
};

/// Patterns of the square on the faces of HEALPix (Gorski et al. 2005), twelve squares of equal area:
/// point i of the set is point `i / 12` of the pattern on face `i % 12` of an order of the faces; on the
/// hemisphere six faces have one direction of each antipodal pair.
///
/// If the pattern on the square is a sequence whose first 4^k points lie in the 4^k cells of a grid, one
/// in each, the first 12 * 4^k directions lie one in each pixel of nside 2^k: a hierarchy of nested
/// HEALPix grids.
///
/// The order of the faces keeps the first faces apart. With random patterns, which are independent on
/// different faces, it is relabelled by a random symmetry of the rhombic dodecahedron, of which
/// HEALPix has the faces: every direction of a set is then uniform on the domain if that is true of
/// the pattern. Otherwise the set is always the same.
///
/// ```
/// use sphvar_samplers::{Domain, OnFaces, Purpose, Sampler, SobolSequence, Streams};
/// let sampler = OnFaces::new(48, Domain::Sphere, SobolSequence::new)?;
/// let set = sampler.sample(&mut Streams::new(0, Purpose::Pattern, 48).realization(0))?;
/// assert_eq!(set.len(), 48);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct OnFaces<P> {
    n_points: usize,
    domain: Domain,
    /// The patterns of the faces in their order.
    parts: Vec<P>,
}

/// The centres of the faces of the rhombic dodecahedron that has the topology of HEALPix, by the
/// numbers of the faces: rotated about z, the faces lie one upon the other.
const CENTRES: [[i8; 3]; 12] = [
    [1, 0, 1],
    [0, 1, 1],
    [-1, 0, 1],
    [0, -1, 1],
    [1, -1, 0],
    [1, 1, 0],
    [-1, 1, 0],
    [-1, -1, 0],
    [1, 0, -1],
    [0, 1, -1],
    [-1, 0, -1],
    [0, -1, -1],
];

/// The order of the faces of which the sum over all prefixes of N times the squared L2 cap
/// discrepancy is smallest, with independent uniform points on the faces.
const ORDER: [usize; 12] = [0, 7, 9, 4, 6, 2, 8, 1, 11, 3, 5, 10];

/// The same for antipodal pairs of faces.
const HEMISPHERE_ORDER: [usize; 6] = [0, 2, 1, 3, 4, 5];

impl<P: SquareSampler> OnFaces<P> {
    /// Returns the pattern of `n_points` directions; `part` returns the pattern on a face for a number
    /// of points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`, and the errors of `part`.
    pub fn new(
        n_points: usize,
        domain: Domain,
        part: impl Fn(usize) -> Result<P, Error>,
    ) -> Result<Self, Error> {
        count::checked(n_points)?;
        let n_faces = order(domain).len();
        let parts = (0..n_points.min(n_faces))
            .map(|turn| part((n_points - turn).div_ceil(n_faces)))
            .collect::<Result<_, _>>()?;
        Ok(Self { n_points, domain, parts })
    }
}

/// Returns the faces in their order.
fn order(domain: Domain) -> &'static [usize] {
    match domain {
        Domain::Sphere => &ORDER,
        Domain::Hemisphere => &HEMISPHERE_ORDER,
    }
}

/// The symmetries of the cube: permutations of the axes and changes of signs.
const AXES: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// Returns the face to which one of the 48 symmetries of the rhombic dodecahedron takes a face; on the
/// hemisphere the face of the antipodal pair.
fn image(face: usize, symmetry: usize, domain: Domain) -> usize {
    let centre = AXES[symmetry / 8].map(|axis| CENTRES[face][axis]);
    let signed = |sign: i8| {
        let flip = |d: usize| sign * if symmetry >> d & 1 == 1 { -centre[d] } else { centre[d] };
        let moved = [flip(0), flip(1), flip(2)];
        CENTRES.iter().position(|centre| *centre == moved).unwrap_or(face)
    };
    match domain {
        Domain::Sphere => signed(1),
        Domain::Hemisphere => signed(1).min(signed(-1)),
    }
}

impl<P: SquareSampler> Sampler for OnFaces<P> {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        if self.parts.iter().any(SquareSampler::is_random) {
            SetDistribution::Random
        } else {
            SetDistribution::Fixed
        }
    }

    fn nominal_work(&self) -> f64 {
        self.parts.iter().map(SquareSampler::nominal_work).sum()
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
        let symmetry =
            if self.distribution().is_random() { rng.random_range(0..8 * AXES.len()) } else { 0 };
        let points = set.start();
        points.resize(self.n_points, DVec3::ZERO);
        let n_faces = order(self.domain).len();
        let cells: Vec<Cell> = strata(Nside::nearest(12), self.domain).collect();
        let mut square = PointSet::default();
        for (turn, (part, &face)) in self.parts.iter().zip(order(self.domain)).enumerate() {
            // A generator for each face: the numbers of one do not depend on those of points on
            // others.
            let mut seed = [0; 32];
            rng.fill_bytes(&mut seed);
            let share = Share::new(progress, part.nominal_work());
            part.sample_watched(&mut ChaCha8Rng::from_seed(seed), &mut square, &share)?;
            share.finish()?;
            let cell = cells[image(face, symmetry, self.domain)];
            for (j, [u, v]) in square.points.iter().enumerate() {
                let direction = cell.uniform_point(*u, *v);
                points[n_faces * j + turn] = self.domain.representative(direction);
            }
        }
        Ok(())
    }
}
