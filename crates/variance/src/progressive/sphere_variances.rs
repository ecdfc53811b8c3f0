//! Variances of all prefixes of a set of directions.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{PointSet, Progress};
use sphvar_sh::{Bands, ByParity};

use super::chord_kernel::{ChordKernel, Columns, Row};
use super::low_degrees::LowDegrees;
use super::space::PrefixVariances;
use crate::Error;
use sphvar_integrands::Energy;

/// The largest degree whose coefficients are accumulated.
const MAX_LOW_DEGREE: usize = 64;
/// The error of the double sum of the kernel that is allowed, relative to the variance that any
/// points have from degrees beyond 2 sqrt(N).
const TOLERANCE: f64 = 1e-4;
/// A bound of the error of a mean of the kernel over pairs, from interpolation and rounding,
/// relative to its largest value.
const KERNEL_ERROR: f64 = 1e-12;
/// The nominal work of a pair of points.
const PAIR_WORK: f64 = 0.1;

/// The variances of integrating a function of known energies with every prefix of a set.
///
/// With the factor k of the domain, the variance after rotation is a mean over pairs,
///
/// ```text
/// V_N = sum_{i,j <= N} w_i w_j A(x_i . x_j)/(sum w)^2,   A(t) = k sum_{l >= 1} E(l) P_l(t)
/// ```
///
/// so that a point adds N values of A, and all prefixes cost N^2/2. For smooth functions the sum is
/// many orders of magnitude smaller than its terms. The lowest degrees, where such functions have
/// their energy, are therefore sums of squares of coefficients. Degrees beyond the last known one have
/// the power of coincident and antipodal points, as in [`predict`](crate::predict).
#[derive(Debug)]
pub(super) struct SphereVariances {
    low: Option<LowDegrees>,
    /// The coefficients of the other degrees, if there are any.
    high: Option<Vec<f64>>,
    /// The kernel with these coefficients.
    kernel: OnceLock<ChordKernel>,
    /// k times the energy beyond the last degree.
    tail: ByParity,
    /// Whether the energies are estimates.
    has_estimates: bool,
}

/// The numbers of a prefix, up to the division by the square of the sum of the weights.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    row: Row,
    weights: f64,
    magnitudes: f64,
}

impl SphereVariances {
    /// Returns the sums for energies to degree `last` and prefixes of up to `n_points`.
    pub(super) fn new(energy: &Energy, last: usize, n_points: usize) -> Result<Self, Error> {
        let domain = *energy.bands();
        let factor = domain.factor(1);
        let last = last.min(energy.lmax());
        let mut coefficients: Vec<f64> =
            energy.per_band()[..=last].iter().map(|e| factor * e).collect();
        coefficients[0] = 0.0;
        let tail = energy.beyond_by_class(last).map(|e| factor * e);
        let split = split(&coefficients, tail.sum(), domain.count_on_sphere(n_points).sqrt());
        let low = &coefficients[..(split + 1).min(coefficients.len())];
        let low = (split > 0).then(|| LowDegrees::new(low)).transpose()?;
        let len = coefficients.len();
        coefficients[..(split + 1).min(len)].fill(0.0);
        // The kernel also finds the coincident points that determine a tail.
        let has_pairs = tail.sum() > 0.0 || coefficients.iter().any(|c| *c != 0.0);
        let (high, has_estimates) = (has_pairs.then_some(coefficients), energy.errors().is_some());
        Ok(Self { low, high, kernel: OnceLock::new(), tail, has_estimates })
    }
}

impl PrefixVariances<DVec3> for SphereVariances {
    fn has_tail(&self) -> bool {
        self.tail.sum() > 0.0
    }

    fn has_estimates(&self) -> bool {
        self.has_estimates
    }

    fn prepare(&self, progress: &dyn Progress) -> Result<(), Error> {
        if let (Some(coefficients), None) = (&self.high, self.kernel.get()) {
            // Another thread may have set the same kernel.
            let _ = self.kernel.set(ChordKernel::new(coefficients, progress)?);
        }
        Ok(())
    }

    fn preparation_work(&self) -> f64 {
        self.high.as_deref().map_or(0.0, ChordKernel::work)
    }

    fn work(&self, n_points: usize) -> f64 {
        let n = n_points as f64;
        let low = self.low.as_ref().map_or(0.0, LowDegrees::work_of_point);
        let pairs = if self.high.is_some() { 0.5 * PAIR_WORK * n } else { 0.0 };
        n * (low + pairs)
    }

    fn of_set(
        &self,
        set: &PointSet,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<Vec<[f64; 2]>, Error> {
        self.prepare(progress)?;
        let kernel = self.kernel.get();
        let mut set = set.clone();
        set.normalize_weights();
        let columns = Columns::new(&set);
        let last = counts.last().copied().unwrap_or(0);
        let row = |i: usize| {
            progress.tick(if kernel.is_some() { PAIR_WORK * i as f64 } else { 0.0 })?;
            Ok(kernel.map_or_else(Row::default, |kernel| kernel.row(&columns, i)))
        };
        let rows = (0..last).into_par_iter().map(row).collect::<Result<Vec<_>, Error>>()?;
        let low = match &self.low {
            Some(low) => low.sums(&set, counts, progress)?,
            None => vec![0.0; counts.len()],
        };
        progress.tick(last as f64 * self.low.as_ref().map_or(0.0, LowDegrees::work_of_point))?;
        let (mut sums, mut next) = (Sums::default(), 0);
        let of_count = |(&count, low): (&usize, f64)| {
            for (k, row) in (next..).zip(&rows[next..count]) {
                let weight = set.weights.get(k).copied().unwrap_or(1.0);
                sums.row.kernel += row.kernel;
                sums.row.coincidences.even += row.coincidences.even;
                sums.row.coincidences.odd += row.coincidences.odd;
                sums.weights += weight;
                sums.magnitudes += weight.abs();
            }
            next = count;
            if sums.weights.abs() <= f64::EPSILON * sums.magnitudes {
                return [f64::NAN; 2];
            }
            let square = sums.weights * sums.weights;
            let tail = self.tail.dot(sums.row.coincidences) / square;
            [(low + sums.row.kernel) / square + tail, tail]
        };
        Ok(counts.iter().zip(low).map(of_count).collect())
    }
}

/// Returns the last degree whose coefficients are accumulated: the lowest one such that the errors of
/// the kernel of the others do not matter.
///
/// The variance of N points is at least about `1/N` times the sum of A beyond degree 2 sqrt(N), where
/// the power of any points is 1, and the error of V is [`KERNEL_ERROR`] times A(1).
fn split(coefficients: &[f64], tail: f64, root: f64) -> usize {
    let beyond = |degree: f64| {
        let of_sum = coefficients.iter().enumerate().filter(|(l, _)| *l as f64 > degree);
        of_sum.map(|(_, c)| c).sum::<f64>()
    };
    let allowed = TOLERANCE * (beyond(2.0 * root) + tail) / (root * root);
    let is_enough = |l: &usize| KERNEL_ERROR * beyond(*l as f64) <= allowed;
    (0..MAX_LOW_DEGREE).find(is_enough).unwrap_or(MAX_LOW_DEGREE)
}
