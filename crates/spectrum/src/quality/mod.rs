//! Measures of one point set: discrepancies, worst-case errors and energies as sums over its pairs;
//! on the square, star discrepancies and L2 discrepancies.

mod all_pairs;
mod condition;
mod ensemble_quality;
mod exact_degree;
mod exponential_integral;
mod heat;
mod hyperuniformity;
mod kernel;
mod measure;
mod near_pairs;
mod nodes;
mod power_series;
mod set_quality;
mod split;
mod square;
mod table;
#[cfg(test)]
mod test_sets;
#[cfg(test)]
mod tests;
mod tridiagonal;
mod unavailable;
mod uniformity;

use std::f64::consts::{LN_2, PI};

use sphvar_samplers::{Domain, PointSet, Progress};

pub use condition::{MAX_CONDITION, condition_number};
pub use ensemble_quality::Quality;
pub use exact_degree::{EXACT_POWER, exact_degree};
pub use hyperuniformity::{
    Hyperuniformity, HyperuniformityClass, hyperuniformity, hyperuniformity_degree,
};
pub use measure::Measure;
pub use set_quality::{MAX_POINTS_OF_COVERING, SetQuality};
pub use sphvar_samplers::{covering_radius, separation, toroidal_separation};
pub use square::{
    MAX_POINTS_OF_L2_DISCREPANCY, MAX_POINTS_OF_STAR_DISCREPANCY, SquareQuality,
    l2_star_discrepancy, star_discrepancy, wraparound_l2_discrepancy,
};
pub use unavailable::Unavailable;
pub use uniformity::{
    ObservedDiscrepancy, TailProbabilities, UniformityStatistic, test_uniformity,
};

use crate::Error;
use kernel::Kernel;
use near_pairs::Effort;
use nodes::Nodes;
use split::Split;

/// The smoothness s of the Sobolev spaces H^s of [`PairSums::worst_case_error`].
pub const WORST_CASE_SMOOTHNESS: [f64; 4] = [1.5, 2.0, 3.0, 4.0];

/// The exponents s of the Riesz energies of [`PairSums::riesz_energy`]; 0 is the logarithmic
/// energy.
pub const RIESZ_EXPONENTS: [f64; 3] = [0.0, 1.0, 2.0];

/// Discrepancies, worst-case errors and Riesz energies of a point set.
///
/// Weights `w_k` are normalized to the sum 1; `r` is a chord, `x . y` the cosine of an angle, and
/// `N_eff = 1/sum w^2` the number of points for equal weights. With the power spectrum P(l) of the
/// set, every discrepancy and error is a sum over degrees, `D^2 = (1/N_eff) sum_(l>=1) (2l+1) k_l
/// P(l)`, and a sum over pairs of a zonal kernel, `D^2 = sum_jk w_j w_k K(x_j, x_k)`.
///
/// On the hemisphere the sums over degrees extend over even ones: the discrepancies and errors are
/// those of the antipodal set of all `x_k` and `-x_k`, for functions with `f(x) = f(-x)`. The
/// energies sum `f(|x_j - x_k|) + f(|x_j + x_k|)` over unordered pairs of points, as
/// [`sphvar_samplers::riesz_energy`] does.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, PointSet};
/// use sphvar_spectrum::quality::PairSums;
///
/// let mut points = DVec3::AXES.to_vec();
/// points.extend(DVec3::AXES.map(|p| -p));
/// let octahedron = PairSums::new(&PointSet::new(points), Domain::Sphere, &())?;
/// // Thomson's problem for six charges: 12/sqrt 2 + 3/2.
/// let coulomb = octahedron.riesz_energy[1].expect("the points are distinct");
/// assert!((coulomb - 9.985281374).abs() < 1e-9);
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
///
/// # References
///
/// Stolarsky 1973 (invariance principle); Cui and Freeden 1997, eq. 13; Brauchart, Saff, Sloan and
/// Womersley 2014, doi:10.1090/S0025-5718-2014-02839-1; Ewald 1921 (split sums).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairSums {
    /// The L2 spherical cap discrepancy D, not squared: `D^2 = (4/3 - sum_jk w_j w_k r)/4 =
    /// (1/N_eff) sum_l P(l)/((2l-1)(2l+3))`.
    pub cap_discrepancy_l2: f64,
    /// The generalized discrepancy D of Cui and Freeden, not squared: `D^2 = (1/(4 pi)) sum_jk w_j
    /// w_k (1 - 2 ln(1 + r/2)) = (1/(4 pi N_eff)) sum_l P(l)/(l(l+1))`.
    pub generalized_discrepancy: f64,
    /// The worst-case errors of the weighted mean over functions of norm 1 in H^s, for s of
    /// [`WORST_CASE_SMOOTHNESS`]: `wce^2 = (1/N_eff) sum_l (2l+1) P(l) (1 + l(l+1))^-s`. The norm
    /// is that of the normalized measure; for the integral with orthonormal coefficients multiply
    /// by `sqrt(4 pi)`.
    pub worst_case_error: [f64; 4],
    /// The Riesz energies over unordered pairs, for s of [`RIESZ_EXPONENTS`]: `N_eff^2 sum_(j<k)
    /// w_j w_k r^-s`, and `-ln r` for s = 0. For equal weights the factor of each pair is 1. `None`
    /// if points coincide up to rounding.
    pub riesz_energy: [Option<f64>; 3],
}

impl PairSums {
    /// The largest number of points for which [`Self::new`] sums over all pairs.
    pub const MAX_DIRECT_POINTS: usize = 20_000;

    /// The relative accuracy of [`Self::new`] for larger sets.
    pub const ACCURACY: f64 = 1e-10;

    /// The largest number of near pairs that [`Self::fast`] sums, some minutes of one core.
    pub const MAX_NEAR_PAIRS: f64 = 2e10;

    /// Returns the sums by [`Self::direct`] to [`Self::MAX_DIRECT_POINTS`] points, those and their
    /// antipodes on the hemisphere, and by [`Self::fast`] beyond.
    ///
    /// # Errors
    ///
    /// Those of [`Self::direct`] and [`Self::fast`].
    pub fn new(set: &PointSet, domain: Domain, progress: &dyn Progress) -> Result<Self, Error> {
        let images = if domain == Domain::Hemisphere { 2 } else { 1 };
        if set.len() <= Self::MAX_DIRECT_POINTS / images {
            Self::direct(set, domain, progress)
        } else {
            Self::fast(set, domain, Self::ACCURACY, progress)
        }
    }

    /// Returns the sums over all pairs of points.
    ///
    /// The kernels of discrepancies and energies are their closed forms. Those of worst-case errors
    /// have none, and their sums cancel: the squared error of good sets is about `N^-s`, below
    /// rounding for s = 4. They are split as in [`Self::fast`], with the transform by its
    /// definition.
    ///
    /// The relative error is about 1e-11. The cost is `O(N^2)`, about 20 ns a pair.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] for invalid sets, weights whose sum is 0, and if `progress` stops the
    /// work.
    pub fn direct(set: &PointSet, domain: Domain, progress: &dyn Progress) -> Result<Self, Error> {
        let images = if domain == Domain::Hemisphere { 2 } else { 1 };
        let split = Split::new(images * set.len(), 1e-12);
        let nodes = Nodes::new(set, domain, split.radius() / 3.0)?;
        let pairs = 0.5 * (nodes.len() as f64).powi(2);
        progress.expect(
            split.nominal_work(&nodes, Effort::Definition, pairs)
                + all_pairs::nominal_work(nodes.len()),
        );
        let (mut sums, has_coincident) = split.sums(&nodes, Effort::Definition, progress)?;
        let [cap, cui_freeden, logarithm, coulomb, inverse_square] =
            all_pairs::all_pairs(&nodes, progress)?;
        let squares = nodes.sum_of_squares();
        sums[0] = (2.0 * cap + squares) / 3.0;
        sums[1] = 2.0 * cui_freeden + squares;
        sums[6..].copy_from_slice(&[logarithm, coulomb, inverse_square].map(|sum| 2.0 * sum));
        Ok(Self::from_sums(&sums, squares, set.n_effective(), domain, has_coincident))
    }

    /// Returns the sums to about a relative `accuracy`, from 1e-11 to 1e-3, for sets of any size.
    ///
    /// Every kernel is split into a smooth part, which is summed over the spectrum, and a part of
    /// short range, which is summed over near pairs. Unlike a spectrum that is truncated, this is
    /// accurate whatever the power at high degrees.
    ///
    /// Each point has about 1000 near points where they are evenly spread: 10^6 points take about 6
    /// s on two cores and 200 bytes each, twice that on the hemisphere. Identical points are
    /// merged. Clusters take more time and, up to 440 MB, more memory. Beyond 10^6 points the
    /// rounding of coordinates can limit the errors of s = 3 and 4 to 1e-9, where sets have almost
    /// no power at low degrees.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for an accuracy out of range; [`Error::NearPairs`] for points so close
    /// together, but not identical, that there are more than [`Self::MAX_NEAR_PAIRS`] near pairs;
    /// [`Error::Transform`] if memory cannot be allocated; otherwise those of [`Self::direct`].
    pub fn fast(
        set: &PointSet,
        domain: Domain,
        accuracy: f64,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        if !(1e-11..=1e-3).contains(&accuracy) {
            let what = "the accuracy of pair sums";
            return Err(Error::Setting { what, expected: "from 1e-11 to 1e-3", got: accuracy });
        }
        let images = if domain == Domain::Hemisphere { 2 } else { 1 };
        let split = Split::new(images * set.len(), accuracy);
        let nodes = Nodes::new(set, domain, split.radius() / 3.0)?;
        progress.tick(0.0)?;
        let (split, pairs) = split.for_near_pairs(&nodes);
        if pairs > Self::MAX_NEAR_PAIRS {
            return Err(Error::NearPairs { pairs, max: Self::MAX_NEAR_PAIRS });
        }
        progress.expect(split.nominal_work(&nodes, Effort::Fast, pairs));
        let (sums, has_coincident) = split.sums(&nodes, Effort::Fast, progress)?;
        let squares = nodes.sum_of_squares();
        Ok(Self::from_sums(&sums, squares, set.n_effective(), domain, has_coincident))
    }

    /// Returns the constants of the second terms of the energies, for comparison between numbers of
    /// points; `n_effective` is [`PointSet::n_effective`].
    ///
    /// ```text
    /// s = 0   E = (1/4 - ln(2)/2) N^2 - N ln(N)/4 + c N    c = -0.0278 or more for large N
    /// s = 1   E = N^2/2 + c N^(3/2)                        c = -0.5530 or more
    /// s = 2   E = N^2 ln(N)/8 + c N^2                      c = -0.0429 or more
    /// ```
    ///
    /// The bounds are those of the hexagonal lattice, conjectured. On the hemisphere the constants
    /// are those of the antipodal set.
    ///
    /// # References
    ///
    /// Brauchart, Hardin and Saff 2012, arXiv:1202.4037.
    #[must_use]
    pub fn riesz_constants(&self, n_effective: f64, domain: Domain) -> [Option<f64>; 3] {
        let scaled = |i: usize, constant: fn(f64, f64) -> f64| {
            self.riesz_energy[i].map(|energy| match domain {
                Domain::Sphere => constant(energy, n_effective),
                // Four pairs of the antipodal set for each two terms, and a point with its
                // antipode.
                Domain::Hemisphere => {
                    let kernel = Kernel::ALL[ENERGIES + i];
                    let own = kernel.at_antipode().unwrap_or(0.0);
                    constant(2.0 * energy + n_effective * own, 2.0 * n_effective)
                }
            })
        };
        [
            scaled(0, |energy, n| (energy - (0.25 - 0.5 * LN_2) * n * n + 0.25 * n * n.ln()) / n),
            scaled(1, |energy, n| (energy - 0.5 * n * n) / n.powf(1.5)),
            scaled(2, |energy, n| (energy - 0.125 * n * n * n.ln()) / (n * n)),
        ]
    }

    /// Returns the measures of the sums of all kernels over pairs of nodes, whose squared weights
    /// have the sum `squares`.
    fn from_sums(
        sums: &[f64; Kernel::ALL.len()],
        squares: f64,
        n_effective: f64,
        domain: Domain,
        has_coincident: bool,
    ) -> Self {
        // Rounding can make a sum that is almost 0 negative.
        let root = |sum: f64| sum.max(0.0).sqrt();
        Self {
            cap_discrepancy_l2: root(sums[0]),
            generalized_discrepancy: root(sums[1] / (4.0 * PI)),
            worst_case_error: std::array::from_fn(|i| root(sums[2 + i])),
            riesz_energy: std::array::from_fn(|i| {
                let sum = sums[ENERGIES + i];
                let over_ordered = match domain {
                    Domain::Sphere => 0.5 * sum,
                    // Pairs of a point, of weight w/2, with its own antipode do not count.
                    Domain::Hemisphere => {
                        let own = Kernel::ALL[ENERGIES + i].at_antipode().unwrap_or(0.0);
                        sum - squares * own
                    }
                };
                (!has_coincident).then_some(n_effective * n_effective * over_ordered)
            }),
        }
    }
}

/// The index of the first energy among the kernels.
const ENERGIES: usize = 6;
