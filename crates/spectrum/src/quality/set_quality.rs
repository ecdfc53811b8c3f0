use sphvar_samplers::{Domain, PointSet, Progress, covering_radius, separation};

use super::{PairSums, Unavailable, condition_number, exact_degree};
use crate::Error;

/// The largest number of points for which [`SetQuality`] has a covering radius and condition
/// numbers. They take about 1 s and 10 s there.
pub const MAX_POINTS_OF_COVERING: usize = 100_000;

/// The measures of one point set.
#[derive(Clone, Debug)]
pub struct SetQuality {
    /// The domain.
    pub domain: Domain,
    /// The number of points.
    pub n_points: usize,
    /// [`PointSet::n_effective`].
    pub n_effective: f64,
    /// [`separation`]; `None` for a single point.
    pub separation: Option<f64>,
    /// [`covering_radius`].
    pub covering_radius: Result<f64, Unavailable>,
    /// Discrepancies, worst-case errors and energies; unavailable for points so close together that
    /// [`PairSums`] cannot be summed.
    pub sums: Result<PairSums, Unavailable>,
    /// [`exact_degree`].
    pub exact_degree: usize,
    /// Degrees with the [`condition_number`] of fits to them.
    pub condition: Vec<(usize, Result<f64, Unavailable>)>,
}

impl SetQuality {
    /// Returns the measures of a set, with the condition numbers of fits to each of `degrees`.
    ///
    /// # Errors
    ///
    /// Those of [`PairSums::new`] except [`Error::NearPairs`], [`exact_degree`] and
    /// [`condition_number`].
    pub fn new(
        set: &PointSet,
        domain: Domain,
        degrees: &[usize],
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let sums = match PairSums::new(set, domain, progress) {
            Err(error @ Error::NearPairs { .. }) => Err(Unavailable::new(error.to_string())),
            sums => Ok(sums?),
        };
        let is_large = set.len() > MAX_POINTS_OF_COVERING;
        let too_many =
            || Unavailable::new(format!("computed for at most {MAX_POINTS_OF_COVERING} points"));
        let covering_radius = if is_large {
            Err(too_many())
        } else {
            covering_radius(&set.points, domain, progress)?.ok_or_else(too_many)
        };
        let condition = degrees.iter().map(|&lmax| {
            let condition = if is_large {
                Err(too_many())
            } else {
                condition_number(set, domain, lmax, progress)?
            };
            Ok::<_, Error>((lmax, condition))
        });
        Ok(Self {
            domain,
            n_points: set.len(),
            n_effective: set.n_effective(),
            separation: separation(&set.points, domain, progress)?,
            covering_radius,
            sums,
            exact_degree: exact_degree(set, domain, progress)?,
            condition: condition.collect::<Result<_, _>>()?,
        })
    }

    /// Returns the mesh ratio, twice the covering radius over the separation; `None` where points
    /// coincide or one of the two is unknown.
    #[must_use]
    pub fn mesh_ratio(&self) -> Option<f64> {
        let separation = self.separation.filter(|s| *s > 0.0)?;
        self.covering_radius.as_ref().ok().map(|covering| 2.0 * covering / separation)
    }

    /// Returns degrees for which fits to `n_points` values are well posed with good points: a
    /// fourth and half of sqrt(N), for which N counts points on the sphere.
    #[must_use]
    pub fn default_degrees(n_points: usize, domain: Domain) -> Vec<usize> {
        let root = (n_points * domain.degree_step()).isqrt();
        let mut degrees: Vec<usize> =
            [root / 4, root / 2].map(|l| l / domain.degree_step() * domain.degree_step()).to_vec();
        degrees.retain(|&l| l > 0);
        degrees.dedup();
        degrees
    }
}
