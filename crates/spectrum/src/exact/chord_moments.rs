use std::f64::consts::PI;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;

use super::partition::Partition;
use super::quadrature::Quadrature;
use crate::{Error, ExactSum};

/// Number of node pairs that share a pass of the recurrence.
const LANES: usize = 8;

/// The nominal work of one pair of nodes for one moment.
const PAIR_WORK: f64 = 1.0 / 60.0;

/// The distribution of the squared chord between two independent uniform points of one stratum,
/// averaged over strata, represented by its Chebyshev moments
///
/// ```text
/// c_j = E T_j(1 - 2 s/s_max),   s = |x - y|^2,   0 <= j < K
/// ```
///
/// The mean of a function of s equals that of its interpolating polynomial of degree K - 1 through
/// the Chebyshev points, up to the size of its Chebyshev coefficients from K on.
#[derive(Clone, Debug)]
pub(super) struct ChordMoments {
    moments: Vec<f64>,
    longest_squared: f64,
}

impl ChordMoments {
    /// Returns the first `count` moments, by quadrature accurate up to degree `degree`.
    ///
    /// The cost is `count` steps of a recurrence for each pair of nodes of each class.
    pub(super) fn new(
        partition: &Partition,
        degree: usize,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let longest_squared = partition.longest_chord_squared();
        let zeros = || Ok(vec![ExactSum::default(); count]);
        let sums = (0..partition.n_rows())
            .into_par_iter()
            .flat_map_iter(|row| partition.row(row))
            .fold(zeros, |sums: Result<Vec<ExactSum>, Error>, class| {
                let mut sums = sums?;
                let nodes = class.quadrature(degree)?;
                for (sum, c) in sums.iter_mut().zip(moments_of(&nodes, longest_squared, count)) {
                    sum.add(class.share * c);
                }
                progress.tick(class_work(nodes.points.len(), count))?;
                Ok(sums)
            })
            .reduce(zeros, |a, b| {
                let mut a = a?;
                for (mine, theirs) in a.iter_mut().zip(&b?) {
                    mine.merge(theirs);
                }
                Ok(a)
            })?;
        Ok(Self { moments: sums.iter().map(ExactSum::value).collect(), longest_squared })
    }

    /// Returns `E [1 - P_l(1 - s/2)]` for l from 0 to `lmax`.
    ///
    /// The polynomial through the Chebyshev points `s_k` integrates to `sum_k q_k g(s_k)` with
    /// `q_k = (1/K) (c_0 + 2 sum_{j >= 1} c_j T_j)`. At these points `1 - P_l` is accumulated from
    /// its increments over l, which are positive while it is small and so preserve the relative
    /// accuracy.
    pub(super) fn power(&self, lmax: usize) -> Vec<f64> {
        let count = self.moments.len();
        let angle = |k: usize| PI * (k as f64 + 0.5) / count as f64;
        let weight = |k: usize| {
            let terms = self.moments.iter().enumerate().skip(1);
            let sum: f64 = terms.map(|(j, c)| c * (j as f64 * angle(k)).cos()).sum();
            (self.moments[0] + 2.0 * sum) / count as f64
        };
        let mut points: Vec<LegendreDefect> = (0..count)
            .map(|k| {
                // s_k = s_max (1 - cos)/2; the formula takes half of it.
                let half_chord_squared =
                    0.5 * self.longest_squared * (0.5 * angle(k)).sin().powi(2);
                LegendreDefect::new(weight(k), half_chord_squared)
            })
            .collect();
        let mut power = vec![0.0; lmax + 1];
        for (l, p) in power.iter_mut().enumerate().skip(1) {
            let r = (l - 1) as f64 / l as f64;
            for point in &mut points {
                point.advance(r);
                *p += point.weight * point.value;
            }
        }
        power
    }
}

/// `1 - P_l(1 - v)` at a point and its increment from one degree to the next.
struct LegendreDefect {
    weight: f64,
    versine: f64,
    value: f64,
    increment: f64,
}

impl LegendreDefect {
    fn new(weight: f64, versine: f64) -> Self {
        Self { weight, versine, value: 0.0, increment: 0.0 }
    }

    /// Advances from degree l to l + 1, with `r = l/(l + 1)`.
    fn advance(&mut self, r: f64) {
        self.increment = r * self.increment + (1.0 + r) * self.versine * (1.0 - self.value);
        self.value += self.increment;
    }
}

/// Returns `sum_{x, y} w_x w_y T_j(1 - tau)`, `tau = 2 |x - y|^2/s_max`, over all pairs of nodes.
fn moments_of(nodes: &Quadrature, longest_squared: f64, count: usize) -> Vec<f64> {
    let points = &nodes.points;
    let blocks: Vec<Block> = points
        .chunks(LANES)
        .zip(nodes.weights.chunks(LANES))
        .map(|(points, weights)| Block::new(points, weights))
        .collect();
    // Pairs of a node with itself: T_j(1) = 1.
    let diagonal: f64 = nodes.weights.iter().map(|w| w * w).sum();
    let mut totals = vec![diagonal; count];
    let mut lanes = vec![[0.0; LANES]; count];
    for (i, (x, w)) in points.iter().zip(&nodes.weights).enumerate() {
        lanes.fill([0.0; LANES]);
        for (b, block) in blocks[..i.div_ceil(LANES)].iter().enumerate() {
            block.add(*x, i - b * LANES, 2.0 / longest_squared, &mut lanes);
        }
        for (total, lanes) in totals.iter_mut().zip(&lanes) {
            *total += 2.0 * w * lanes.iter().sum::<f64>();
        }
    }
    totals
}

/// Nodes stored as a structure of arrays.
struct Block {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    weight: [f64; LANES],
}

impl Block {
    fn new(points: &[glam::DVec3], weights: &[f64]) -> Self {
        let lane = |f: &dyn Fn(usize) -> f64| {
            std::array::from_fn(|k| if k < points.len() { f(k) } else { 0.0 })
        };
        Self {
            x: lane(&|k| points[k].x),
            y: lane(&|k| points[k].y),
            z: lane(&|k| points[k].z),
            weight: lane(&|k| weights[k]),
        }
    }

    /// Adds `w T_j(1 - tau)` for the pairs of `other` and the first `used` nodes of the block, per
    /// moment and lane.
    ///
    /// The difference form, `D_{j+1} = D_j - 2 tau T_j`, `T_{j+1} = T_j + D_{j+1}`, is as accurate
    /// for nearby pairs as their distance.
    fn add(&self, other: glam::DVec3, used: usize, scale: f64, sums: &mut [[f64; LANES]]) {
        let mut twice_tau = [0.0; LANES];
        let mut value = [0.0; LANES];
        let mut difference = [0.0; LANES];
        for k in 0..LANES {
            let (x, y, z) = (self.x[k] - other.x, self.y[k] - other.y, self.z[k] - other.z);
            let tau = scale * (x * x + y * y + z * z);
            twice_tau[k] = 2.0 * tau;
            value[k] = if k < used { self.weight[k] } else { 0.0 };
            difference[k] = tau * value[k];
        }
        for sum in sums {
            for k in 0..LANES {
                sum[k] += value[k];
                difference[k] -= twice_tau[k] * value[k];
                value[k] += difference[k];
            }
        }
    }
}

/// Returns the number of moments for degrees up to `lmax` and chords with squared lengths up to
/// `longest_squared`.
///
/// `P_l(1 - s/2)` is a polynomial of degree l in s, whose coefficients are no larger than those of
/// `J_0((l + 1/2) sqrt(s))` and have the same signs. Its Chebyshev coefficients are therefore no
/// larger than those of `I_0`, which are `2 I_j(a)^2` with `a = (l + 1/2) sqrt(s_max)/2`, and
/// `I_j(a) <= (a/2)^j e^(a^2/(4j + 4))/j!`. The omitted coefficients must be below 1e-17 of the
/// maximum of `1 - P_l`, about `min(1, a^2)`.
pub(super) fn n_moments(lmax: usize, longest_squared: f64) -> usize {
    let a = 0.5 * (lmax as f64 + 0.5) * longest_squared.sqrt();
    let goal = 1e-17_f64.ln() + 2.0 * a.ln().min(0.0);
    let mut log_factorial = 0.0;
    for j in 1..=lmax {
        log_factorial += (j as f64).ln();
        let log_bessel = j as f64 * (0.5 * a).ln() - log_factorial + a * a / (4.0 * j as f64 + 4.0);
        // The factor 2 and the sum of all further terms amount to a factor below 4.
        if 2.0 * log_bessel + 4.0_f64.ln() < goal {
            return j.max(2);
        }
    }
    lmax + 1
}

/// Returns the nominal work of all classes, as ticked by [`ChordMoments::new`].
pub(super) fn work(partition: &Partition, lmax: usize) -> f64 {
    let count = n_moments(lmax, partition.longest_chord_squared());
    partition.nodes(lmax).into_iter().map(|(classes, n)| classes * class_work(n, count)).sum()
}

/// Returns the memory in bytes per thread: two copies of the nodes, and the moments.
pub(super) fn bytes(partition: &Partition, lmax: usize) -> f64 {
    let count = n_moments(lmax, partition.longest_chord_squared());
    64.0 * partition.max_nodes(lmax) as f64 + 250.0 * count as f64
}

fn class_work(n_nodes: usize, count: usize) -> f64 {
    0.5 * (n_nodes as f64).powi(2) * (count as f64 + 4.0) * PAIR_WORK
}
