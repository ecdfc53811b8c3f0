use glam::DVec3;
use sphvar_samplers::{PointSet, Progress};

use super::accumulator::errors_of_counts;
use super::angle_bins::{AngleBins, angle_of_chord};
use super::near_pairs::{NearPairs, Pair};
use crate::{Accumulator, Error, Moments, Realization};

/// The local density of points relative to its mean over the domain.
#[derive(Clone, Copy)]
pub enum LocalDensity<'a> {
    /// A function of direction with mean 1 over the domain.
    Function(&'a (dyn Fn(DVec3) -> f64 + Sync)),
    /// The inverse of the weights of the points, scaled so that the mean over the domain, the
    /// weighted mean over the points, is 1.
    InverseWeights,
}

impl std::fmt::Debug for LocalDensity<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Function(_) => "Function",
            Self::InverseWeights => "InverseWeights",
        })
    }
}

/// Accumulates the distribution of differentials of point sets whose density varies: the angles
/// between points, each divided by the mean of the two local scales,
///
/// ```text
/// u_jk = gamma_jk/((a_j + a_k)/2),   a = 1/sqrt(local density)
/// ```
///
/// so that u is an angle at the mean density. A pattern that adapts to a density has about the
/// distribution that the same pattern has at uniform density. The ensemble is rotated or its
/// direction does not matter: only the lengths of differentials are kept.
///
/// # References
///
/// Wei and Wang 2011, "Differential domain analysis for non-uniform sampling", for the isotropic
/// scaling.
#[derive(Clone)]
pub struct DifferentialAccumulator<'a> {
    bins: AngleBins,
    density: LocalDensity<'a>,
    progress: &'a dyn Progress,
    g: Vec<Moments>,
    /// A local density that is not positive and finite.
    wrong_density: Option<f64>,
}

impl std::fmt::Debug for DifferentialAccumulator<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DifferentialAccumulator")
            .field("bins", &self.bins)
            .field("density", &self.density)
            .finish_non_exhaustive()
    }
}

/// The distribution of differentials of an ensemble, relative to that of independent points of the
/// same density.
#[derive(Clone, Debug, PartialEq)]
pub struct Differentials {
    /// The bins of the scaled angle u.
    pub bins: AngleBins,
    /// The number of realizations.
    pub realizations: u64,
    /// The mean number of pairs in each bin over that of independent points whose density does not
    /// vary within u,
    ///
    /// ```text
    /// 1/2 sum_k N lambda_k share(u a_k),   lambda_k = 1/a_k^2
    /// ```
    ///
    /// where the share is the fraction of the domain at these angles from a point. At uniform
    /// density this is the pair correlation. The error of the constant density is of second order
    /// in the relative change of density over the angle u.
    pub g: Vec<f64>,
    /// The standard errors of `g`; NaN for a single realization, and where none
    /// has a pair.
    pub g_stderr: Vec<f64>,
}

impl<'a> DifferentialAccumulator<'a> {
    /// Returns an empty accumulator; see
    /// [`PairCorrelationAccumulator::new`](crate::PairCorrelationAccumulator::new) for `progress`.
    #[must_use]
    pub fn new(bins: AngleBins, density: LocalDensity<'a>, progress: &'a dyn Progress) -> Self {
        let g = vec![Moments::default(); bins.count()];
        Self { bins, density, progress, g, wrong_density: None }
    }

    /// Returns the means and standard errors.
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] if nothing was accumulated, and [`Error::Setting`] if the local
    /// density of a point is not positive and finite.
    pub fn finish(&self) -> Result<Differentials, Error> {
        if let Some(got) = self.wrong_density {
            let (what, expected) =
                ("the local density", "positive and finite at every point, as weights 1/p are");
            return Err(Error::Setting { what, expected, got });
        }
        let realizations = self.g.first().map_or(0, Moments::count);
        if realizations == 0 {
            return Err(Error::NoRealizations);
        }
        Ok(Differentials {
            bins: self.bins,
            realizations,
            g: self.g.iter().map(Moments::mean).collect(),
            g_stderr: errors_of_counts(&self.g),
        })
    }

    /// Returns the local density at the points of a set.
    fn densities(&self, set: &PointSet) -> Vec<f64> {
        match self.density {
            LocalDensity::Function(density) => set.points.iter().map(|&p| density(p)).collect(),
            LocalDensity::InverseWeights if set.weights.is_empty() => vec![1.0; set.len()],
            LocalDensity::InverseWeights => {
                let mean = set.weights.iter().sum::<f64>() / set.len() as f64;
                set.weights.iter().map(|w| mean / w).collect()
            }
        }
    }
}

impl Accumulator for DifferentialAccumulator<'_> {
    fn push(&mut self, realization: &Realization<'_>) {
        let (set, bins) = (realization.set(), self.bins);
        let densities = self.densities(set);
        if let Some(&wrong) = densities.iter().find(|d| !(**d > 0.0 && d.is_finite())) {
            self.wrong_density = Some(wrong);
            return;
        }
        let scales: Vec<f64> = densities.iter().map(|d| d.sqrt().recip()).collect();
        let widest = scales.iter().copied().fold(0.0, f64::max);
        let limit = AngleBins::limit(bins.domain());
        let reach = (bins.max_angle() * widest).min(limit);
        let near = NearPairs::new(set, bins.domain(), 2.0 * (0.5 * reach).sin());
        let add = |pair: Pair| {
            let [j, k] = pair.indices;
            let scaled = angle_of_chord(pair.chord_squared) * 2.0 / (scales[j] + scales[k]);
            Some((bins.bin(scaled)?, pair.share))
        };
        // Nothing is lost when the work is stopped, since the whole result is discarded.
        let Ok(pairs) = near.sums(bins.count(), &add, self.progress) else {
            return;
        };
        let within = |u: f64| {
            let near =
                |(a, d): (&f64, &f64)| d * AngleBins::cap_share(bins.domain(), (u * a).min(limit));
            0.5 * set.len() as f64 * scales.iter().zip(&densities).map(near).sum::<f64>()
        };
        let mut below = 0.0;
        for ((pairs, edge), g) in pairs.iter().zip(bins.upper_edges()).zip(&mut self.g) {
            let up_to = within(edge);
            g.push(pairs / (up_to - below));
            below = up_to;
        }
    }

    fn merge(&mut self, other: &Self) {
        self.g.iter_mut().zip(&other.g).for_each(|(a, b)| a.merge(b));
        self.wrong_density = self.wrong_density.or(other.wrong_density);
    }
}
