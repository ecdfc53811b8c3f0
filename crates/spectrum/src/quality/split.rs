use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;
use sphvar_sh::{Alm, CompensatedSum, GaussLegendre};
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace, Method};

use super::heat::ShortRange;
use super::kernel::{Kernel, upper_gamma};
use super::near_pairs::{Effort, NearPairs};
use super::nodes::Nodes;
use super::table::Table;
use crate::Error;

/// The smallest maximum degree: t is then at most 0.01, as [`ShortRange`] needs.
const MIN_LMAX: usize = 72;

/// The maximum degree in units of sqrt(N) where time decides it.
const DEGREE_BY_TIME: f64 = 4.0;

/// The maximum degree in units of sqrt(N) where memory decides it: the grid of the transform takes
/// 104 bytes for the square of the degree.
const DEGREE_BY_MEMORY: f64 = 1.0;

/// The maximum degree whose grid, 40 MiB, is small whatever the number of points.
const SMALL_DEGREE: f64 = 640.0;

/// The maximum degree for points that are not evenly spread, where a larger degree saves pairs. The
/// grid then takes 440 MB.
const MAX_DEGREE: usize = 2048;

/// The number of near pairs, about a minute of one core, above which the degree is raised.
const MANY_PAIRS: f64 = 5e9;

/// The degree below which coefficients of the fast transform are replaced by exact ones: there sets
/// of good quality have coefficients far below its accuracy, and smooth kernels are largest.
const EXACT_DEGREE: usize = 32;

/// The number of points that the fast transform takes at a time, which bounds its memory.
const FAST_CHUNK: usize = 1 << 16;

/// The number of points that the exact transform takes at a time.
const EXACT_CHUNK: usize = 1 << 12;

/// Sums over all pairs, split into a sum over degrees and one over near pairs.
///
/// ```text
/// sum_jk w_j w_k K(x_j, x_k) = 4 pi sum_(l=1)^L q_l sum_m |a_lm|^2       smooth part
///                            + sum_jk w_j w_k S(x_j, x_k) - mean of S    short-range part
/// ```
#[derive(Debug)]
pub(super) struct Split {
    t: f64,
    lmax: usize,
    short: ShortRange,
    /// The largest squared half chord `sin^2(gamma/2)` of pairs that are summed.
    range: f64,
    accuracy: f64,
}

impl Split {
    /// Returns the split for a number of points, with parts dropped below about `accuracy` of sets
    /// with low discrepancy.
    pub(super) fn new(n_points: usize, accuracy: f64) -> Self {
        let root = (n_points as f64).sqrt();
        let degree = (DEGREE_BY_TIME * root).min((DEGREE_BY_MEMORY * root).max(SMALL_DEGREE));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "four times the root of a number of points"
        )]
        let lmax = (degree as usize).max(MIN_LMAX);
        Self::to_degree(lmax, accuracy)
    }

    fn to_degree(lmax: usize, accuracy: f64) -> Self {
        let smoothest = super::WORST_CASE_SMOOTHNESS[3];
        let mut extent = 10.0;
        while upper_gamma(smoothest, extent) > 0.1 * accuracy {
            extent += 0.25;
        }
        let t = extent / (lmax as f64 + 0.5).powi(2);
        let range = (t * extent).sqrt().sin().powi(2);
        Self { t, lmax, short: ShortRange::new(t), range, accuracy }
    }

    /// Returns the split with a higher degree where the points have too many near pairs otherwise,
    /// and the number of pairs.
    pub(super) fn for_near_pairs(mut self, nodes: &Nodes) -> (Self, f64) {
        let mut pairs = nodes.estimated_pairs(self.radius());
        while pairs > MANY_PAIRS && self.lmax < MAX_DEGREE {
            self = Self::to_degree((2 * self.lmax).min(MAX_DEGREE), self.accuracy);
            pairs = nodes.estimated_pairs(self.radius());
        }
        (self, pairs)
    }

    /// Returns the largest distance of near pairs, in radians.
    pub(super) fn radius(&self) -> f64 {
        2.0 * self.range.sqrt().asin()
    }

    /// Returns the sums over all pairs, of energies without those of a point and itself, and
    /// whether two points coincide.
    pub(super) fn sums(
        &self,
        nodes: &Nodes,
        effort: Effort,
        progress: &dyn Progress,
    ) -> Result<([f64; Kernel::ALL.len()], bool), Error> {
        let energies = match effort {
            Effort::Definition => exact(nodes, self.lmax, progress)?.energy_per_degree(),
            Effort::Fast => {
                let mut energies = fast(nodes, self.lmax, progress)?.energy_per_degree();
                let low = exact(nodes, EXACT_DEGREE, progress)?.energy_per_degree();
                energies[..low.len()].copy_from_slice(&low);
                energies
            }
        };
        let table = Table::new(&self.short, self.range);
        let near = NearPairs::new(nodes, &table, effort, progress)?;
        let (at_zero, means) = (self.short.at_zero(), self.short.means());
        let beyond = self.means_beyond_range()?;
        let squares = nodes.sum_of_squares();
        let sums = std::array::from_fn(|i| {
            let kernel = Kernel::ALL[i];
            if kernel.is_energy() && nodes.len() == 1 {
                // No pair: not even rounding errors.
                return 0.0;
            }
            let mut sum = CompensatedSum::default();
            for (l, energy) in energies.iter().enumerate().skip(1) {
                let coefficient = kernel.smooth_coefficient(l, self.t);
                sum.add(coefficient * 4.0 * PI * energy);
                if kernel.is_energy() {
                    sum.add(-coefficient * (2 * l + 1) as f64 * squares);
                }
            }
            sum.add(2.0 * near.sums[i]);
            // Pairs beyond the range are replaced by their mean over the sphere.
            if kernel.is_energy() {
                let mean = kernel.smooth_coefficient(0, self.t) + beyond[i];
                sum.add(mean * (1.0 - squares));
            } else {
                sum.add(squares * at_zero[i]);
                sum.add(beyond[i]);
                sum.add(-means[i]);
            }
            sum.value()
        });
        Ok((sums, nodes.has_repeated || near.has_coincident))
    }

    /// Returns the contributions of distances beyond the range to the means of the short-range
    /// parts.
    fn means_beyond_range(&self) -> Result<[f64; Kernel::ALL.len()], Error> {
        let rule = GaussLegendre::new(64)?;
        let mut means = [0.0; Kernel::ALL.len()];
        // The parts decrease as exp(-v/t); v is uniform on [0, 1].
        let end = (self.range + 40.0 * self.t).min(1.0);
        let (middle, half) = (0.5 * (end + self.range), 0.5 * (end - self.range));
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            for (mean, value) in means.iter_mut().zip(self.short.at(middle + half * x)) {
                *mean += half * w * value;
            }
        }
        Ok(means)
    }

    /// Returns the nominal work of [`Self::sums`].
    pub(super) fn nominal_work(&self, nodes: &Nodes, effort: Effort, pairs: f64) -> f64 {
        let n = nodes.len();
        let transforms = match effort {
            Effort::Definition => Method::Exact.nominal_work(n, self.lmax),
            Effort::Fast => {
                let chunk = Method::Fast.nominal_work(n.min(FAST_CHUNK), self.lmax);
                let low = Method::Exact.nominal_work(n, EXACT_DEGREE);
                n.div_ceil(FAST_CHUNK) as f64 * chunk + low
            }
        };
        transforms + NearPairs::nominal_work(pairs)
    }
}

/// Returns coefficients by the definition.
pub(super) fn exact(nodes: &Nodes, lmax: usize, progress: &dyn Progress) -> Result<Alm, Error> {
    let transform = ExactTransform::new(lmax)?;
    let n = nodes.len();
    let step = scattering_step(n);
    let parts = (0..n.div_ceil(EXACT_CHUNK)).into_par_iter().map(|chunk| {
        let range = chunk * EXACT_CHUNK..((chunk + 1) * EXACT_CHUNK).min(n);
        let order = range.map(|i| (i as u128 * step as u128 % n as u128) as usize);
        let (points, weights) = gather(nodes, order);
        let mut alm = Alm::zeros(lmax)?;
        transform.adjoint_into(&points, Some(&weights), &mut ExactWorkspace::default(), &mut alm);
        progress.tick(Method::Exact.nominal_work(points.len(), lmax))?;
        Ok(alm)
    });
    let parts = parts.collect::<Result<Vec<Alm>, Error>>()?;
    let mut sum = Alm::zeros(lmax)?;
    for (i, value) in sum.values_mut().iter_mut().enumerate() {
        let re = parts.iter().map(|part| part.values()[i].re).collect::<CompensatedSum>();
        let im = parts.iter().map(|part| part.values()[i].im).collect::<CompensatedSum>();
        *value = Complex::new(re.value(), im.value());
    }
    Ok(sum)
}

/// Returns coefficients by the fast transform.
fn fast(nodes: &Nodes, lmax: usize, progress: &dyn Progress) -> Result<Alm, Error> {
    let transform = FastTransform::new(lmax, FastTransform::MIN_EPSILON)?;
    let mut workspace = FastWorkspace::parallel();
    let (mut sum, mut alm) = (Alm::zeros(lmax)?, Alm::zeros(lmax)?);
    for chunk in 0..nodes.len().div_ceil(FAST_CHUNK) {
        let range = chunk * FAST_CHUNK..((chunk + 1) * FAST_CHUNK).min(nodes.len());
        let (points, weights) = gather(nodes, range);
        transform.adjoint_into(&points, Some(&weights), &mut workspace, &mut alm);
        for (sum, value) in sum.values_mut().iter_mut().zip(alm.values()) {
            *sum += value;
        }
        progress.tick(Method::Fast.nominal_work(points.len(), lmax))?;
    }
    Ok(sum)
}

/// Returns a step near n over the golden ratio that has no common divisor with n: multiples of it
/// modulo n visit every point, each run of them all over the sphere. In their sorted order sums
/// would become large before they cancel, and good sets have coefficients of 1e-9.
fn scattering_step(n: usize) -> usize {
    let gcd = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
    let golden = (n as f64 / f64::midpoint(1.0, 5f64.sqrt())) as usize;
    (1..=golden).rev().find(|&step| gcd(n, step) == 1).unwrap_or(1)
}

/// Returns points and weights in an order.
fn gather(nodes: &Nodes, order: impl Iterator<Item = usize>) -> (Vec<DVec3>, Vec<f64>) {
    order.map(|k| (nodes.point(k), nodes.w[k])).unzip()
}
