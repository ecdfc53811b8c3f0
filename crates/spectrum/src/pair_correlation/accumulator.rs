use std::sync::Arc;

use sphvar_samplers::{Domain, PointSet, Progress};

use super::angle_bins::{AngleBins, ChordBins};
use super::near_pairs::{NearPairs, Pair};
use super::smoothing::HeatSmoothing;
use crate::{Accumulator, Error, Moments, Realization};

/// Accumulates the pair correlation of an ensemble, from its pairs and from its spectrum, with
/// Ripley's K; [`finish`](Self::finish) returns a [`PairCorrelation`].
///
/// Pairs within the largest angle are found by a grid, whose cost is about that of the pairs within
/// three times that angle; if the angle is not small, all pairs are visited.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
/// use sphvar_spectrum::{AngleBins, PairCorrelationAccumulator, Resolution, accumulate};
///
/// let disks = "poisson-disk".parse::<Pattern>()?.build(64, Domain::Sphere)?;
/// let sets = Realizations::rotated(&*disks, Streams::new(0, Purpose::Pattern, 64));
/// let bins = AngleBins::new(Domain::Sphere, 1.0, 20)?;
/// let empty = PairCorrelationAccumulator::new(bins, 40, &())?;
/// let pairs = accumulate(&sets, Resolution::new(40, 64), 0..10, &empty, &())?.finish()?;
/// // No two points are closer than the diameter of the disks.
/// assert!(pairs.g[..5].iter().all(|&g| g == 0.0));
/// assert!((pairs.sum_rule - 1.0).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct PairCorrelationAccumulator<'a> {
    bins: AngleBins,
    chord_bins: Arc<ChordBins>,
    smoothing: Arc<HeatSmoothing>,
    progress: &'a dyn Progress,
    g: Vec<Moments>,
    k: Vec<Moments>,
    g_smooth: Vec<Moments>,
    sum_rule: Moments,
    /// The variance of g for independent points, without the factor of each bin.
    uniform_g: Moments,
    uniform_k: Moments,
}

impl std::fmt::Debug for PairCorrelationAccumulator<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PairCorrelationAccumulator")
            .field("bins", &self.bins)
            .field("realizations", &self.sum_rule.count())
            .finish_non_exhaustive()
    }
}

/// Pair correlation and Ripley's functions of an ensemble. Every estimate is the mean over the
/// realizations, with its standard error; NaN where a single realization does not determine it.
///
/// With weights w, and the sums over ordered pairs of different points,
///
/// ```text
/// g(gamma)  sum_{j != k} w_j w_k [gamma_jk in bin]/((sum w)^2 share of the bin)
/// K(gamma)  area sum_{j != k} w_j w_k [gamma_jk <= gamma]/((sum w)^2 - sum w^2)
/// L(gamma)  the angular radius of the cap of area K, arccos(1 - K/(2 pi))
/// ```
///
/// where the share is the fraction of the domain at these angles from a point. For N independent
/// uniform points the means are `g = 1 - 1/N`, `K = 2 pi (1 - cos gamma)` and, to first order,
/// `L = gamma`. On the hemisphere angles are between lines, and the area is 2 pi.
///
/// If the weights are inverse densities, these are the intensity-reweighted functions of
/// inhomogeneous point processes (Baddeley, Moller and Waagepetersen 2000).
///
/// # References
///
/// Robeson, Li and Huang 2014, "Point-pattern analysis on the sphere"; Moller and Rubak 2016,
/// "Functional summary statistics for point processes on the sphere with an application to
/// determinantal point processes", for K.
#[derive(Clone, Debug, PartialEq)]
pub struct PairCorrelation {
    /// The bins of the angle.
    pub bins: AngleBins,
    /// The number of realizations.
    pub realizations: u64,
    /// The mean of the pair correlation over each bin, `rho_2/rho^2`.
    pub g: Vec<f64>,
    /// The standard errors of `g`; NaN where no realization has a pair.
    pub g_stderr: Vec<f64>,
    /// The standard deviation of `g` for the same number of independent uniform points in as many
    /// realizations. Pairs of such points are independent of each other, so that it is exact.
    pub g_uniform_stderr: Vec<f64>,
    /// The pair correlation of the spectrum in the middle of each bin, smoothed by
    /// [`HeatSmoothing`].
    pub g_smooth: Vec<f64>,
    /// The standard errors of `g_smooth`.
    pub g_smooth_stderr: Vec<f64>,
    /// The standard deviation of the smoothing along each axis in radians.
    pub smoothing_width: f64,
    /// Ripley's K at the upper edge of each bin.
    pub k: Vec<f64>,
    /// The standard errors of `k`; NaN where no realization has a pair.
    pub k_stderr: Vec<f64>,
    /// The standard deviation of `k` for independent uniform points, as of `g`.
    pub k_uniform_stderr: Vec<f64>,
    /// L at the upper edge of each bin in radians; NaN where K exceeds the area of the domain or is
    /// negative, which weights of both signs can cause.
    pub l: Vec<f64>,
    /// The standard errors of `l`.
    pub l_stderr: Vec<f64>,
    /// [`HeatSmoothing::sum_rule`]: 1 if no two points are close, 0 for white noise.
    pub sum_rule: f64,
    /// The standard error of `sum_rule`.
    pub sum_rule_stderr: f64,
}

impl<'a> PairCorrelationAccumulator<'a> {
    /// Returns an empty accumulator for these bins and coefficients to degree `lmax`.
    ///
    /// `progress` can stop the count between pairs. If it stops, the sums are meaningless; it
    /// must be the progress of [`accumulate`](crate::accumulate), which then returns the error.
    ///
    /// # Errors
    ///
    /// Those of [`HeatSmoothing::new`].
    pub fn new(bins: AngleBins, lmax: usize, progress: &'a dyn Progress) -> Result<Self, Error> {
        let moments = vec![Moments::default(); bins.count()];
        Ok(Self {
            bins,
            chord_bins: Arc::new(ChordBins::new(&bins)),
            smoothing: Arc::new(HeatSmoothing::new(lmax, &bins.centres())?),
            progress,
            g: moments.clone(),
            k: moments.clone(),
            g_smooth: moments,
            sum_rule: Moments::default(),
            uniform_g: Moments::default(),
            uniform_k: Moments::default(),
        })
    }

    /// Returns the nominal work of the pairs of one realization, for progress.
    #[must_use]
    pub fn work(bins: &AngleBins, n_points: usize) -> f64 {
        // The pairs of 27 cubes, a few nanoseconds each.
        const WORK_OF_PAIR: f64 = 0.05;
        let n = bins.domain().count_on_sphere(n_points);
        let share = 4.0 * AngleBins::cap_share(Domain::Sphere, bins.max_angle());
        WORK_OF_PAIR * n * n * share.min(1.0)
    }

    /// Returns the means and standard errors.
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] if nothing was accumulated.
    pub fn finish(&self) -> Result<PairCorrelation, Error> {
        let realizations = self.sum_rule.count();
        if realizations == 0 {
            return Err(Error::NoRealizations);
        }
        let domain = self.bins.domain();
        let means = |all: &[Moments]| all.iter().map(Moments::mean).collect::<Vec<f64>>();
        let errors = |all: &[Moments]| all.iter().map(Moments::standard_error).collect();
        let (k, k_stderr) = (means(&self.k), errors_of_counts(&self.k));
        let l: Vec<f64> = k.iter().map(|&k| cap_radius(k, domain)).collect();
        let tau = std::f64::consts::TAU;
        // dK = 2 pi sin(L) dL
        let l_stderr = l
            .iter()
            .zip(&k_stderr)
            .map(|(&l, &e)| if e == 0.0 && l.is_finite() { 0.0 } else { e / (tau * l.sin()) });
        let l_stderr = l_stderr.map(|e| if e.is_finite() { e } else { f64::NAN }).collect();
        let (m, shares) = (realizations as f64, self.bins.shares());
        let of_g = shares.iter().map(|p| (self.uniform_g.mean() * (1.0 - p) / (p * m)).sqrt());
        let of_k = self.bins.upper_edges().into_iter().map(|angle| {
            let p = AngleBins::cap_share(domain, angle);
            (self.uniform_k.mean() * p * (1.0 - p).max(0.0) / m).sqrt()
        });
        Ok(PairCorrelation {
            bins: self.bins,
            realizations,
            g: means(&self.g),
            g_stderr: errors_of_counts(&self.g),
            g_uniform_stderr: of_g.collect(),
            g_smooth: means(&self.g_smooth),
            g_smooth_stderr: errors(&self.g_smooth),
            smoothing_width: self.smoothing.width(),
            k_uniform_stderr: of_k.collect(),
            k,
            k_stderr,
            l,
            l_stderr,
            sum_rule: self.sum_rule.mean(),
            sum_rule_stderr: self.sum_rule.standard_error(),
        })
    }
}

impl PairCorrelation {
    /// Returns the same functions with standard errors of 0, for a set that is studied for its own
    /// sake or differs between realizations by rotations only.
    #[must_use]
    pub fn into_exact(mut self) -> Self {
        let of = |value: f64| if value.is_nan() { f64::NAN } else { 0.0 };
        for (errors, values) in [
            (&mut self.g_stderr, &self.g),
            (&mut self.g_smooth_stderr, &self.g_smooth),
            (&mut self.k_stderr, &self.k),
            (&mut self.l_stderr, &self.l),
        ] {
            *errors = values.iter().map(|&value| of(value)).collect();
        }
        self.sum_rule_stderr = of(self.sum_rule);
        self
    }
}

/// Returns the standard errors of numbers of pairs; NaN where all realizations agree in having none,
/// which does not show how often one occurs.
pub(super) fn errors_of_counts(all: &[Moments]) -> Vec<f64> {
    let error = |m: &Moments| Some(m.standard_error()).filter(|&e| e > 0.0 || m.mean() > 0.0);
    all.iter().map(|m| error(m).unwrap_or(f64::NAN)).collect()
}

/// Returns the angular radius of the cap (on the hemisphere, of lines) of area `k`; NaN if there is
/// none.
fn cap_radius(k: f64, domain: Domain) -> f64 {
    // K = 4 pi sin^2(L/2) on the sphere and 2 pi (1 - cos L), the same, between lines. The area
    // itself may be exceeded by rounding.
    let share = k / domain.area();
    if !(0.0..=1.0 + 1e-12).contains(&share) {
        return f64::NAN;
    }
    2.0 * (k / (4.0 * std::f64::consts::PI)).sqrt().min(1.0).asin()
}

/// The sums of the weights of a set and of their powers.
struct WeightPowers {
    sum: f64,
    squares: f64,
    fourths: f64,
}

impl WeightPowers {
    fn of(set: &PointSet) -> Self {
        if set.weights.is_empty() {
            let n = set.len() as f64;
            return Self { sum: n, squares: n, fourths: n };
        }
        let power = |p: i32| set.weights.iter().map(|w| w.powi(p)).sum::<f64>();
        Self { sum: power(1), squares: power(2), fourths: power(4) }
    }
}

impl Accumulator for PairCorrelationAccumulator<'_> {
    fn push(&mut self, realization: &Realization<'_>) {
        let (set, domain) = (realization.set(), self.bins.domain());
        let bins = self.bins;
        let near = NearPairs::new(set, domain, 2.0 * (0.5 * bins.max_angle()).sin());
        let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
        let chord_bins = &*self.chord_bins;
        let add = |pair: Pair| {
            let [j, k] = pair.indices;
            let bin = chord_bins.bin(pair.chord_squared)?;
            Some((bin, pair.share * weight(j) * weight(k)))
        };
        // Nothing is lost when the work is stopped, since the whole result is discarded.
        let Ok(sums) = near.sums(bins.count(), &add, self.progress) else {
            return;
        };
        let WeightPowers { sum, squares, fourths } = WeightPowers::of(set);
        let n_effective = realization.n_effective();
        // Weights whose sum is 0 have no density, and a single point, or one that outweighs all
        // others to rounding, has no pairs.
        let all = if n_effective > 0.0 { sum * sum } else { f64::NAN };
        let has_pairs = (n_effective - 1.0).abs() > 1e-12;
        let distinct = if has_pairs { all - squares } else { f64::NAN };
        let mut below = 0.0;
        let of_bins = sums.iter().zip(bins.shares()).zip(self.g.iter_mut().zip(&mut self.k));
        for ((pairs, share), (g, k)) in of_bins {
            below += pairs;
            g.push(2.0 * pairs / (all * share));
            k.push(domain.area() * 2.0 * below / distinct);
        }
        // The variance of sum_{j<k} 2 w_j w_k [..] is p (1 - p) 4 sum_{j<k} w_j^2 w_k^2.
        let variance = 2.0 * (squares * squares - fourths).max(0.0);
        self.uniform_g.push(variance / (all * all));
        self.uniform_k.push(variance * (domain.area() / distinct).powi(2));
        let power: Vec<f64> = realization.power().collect();
        let n_effective = if n_effective > 0.0 { n_effective } else { f64::NAN };
        let smooth = self.smoothing.values(&power, n_effective, &domain);
        self.g_smooth.iter_mut().zip(smooth).for_each(|(moments, g)| moments.push(g));
        let n_effective = if has_pairs { n_effective } else { f64::NAN };
        self.sum_rule.push(self.smoothing.sum(&power, n_effective, &domain));
        // A stop is noticed by the caller.
        let _ = self.progress.tick(Self::work(&bins, set.len()));
    }

    fn merge(&mut self, other: &Self) {
        let lists = [
            (&mut self.g, &other.g),
            (&mut self.k, &other.k),
            (&mut self.g_smooth, &other.g_smooth),
        ];
        for (mine, theirs) in lists {
            mine.iter_mut().zip(theirs).for_each(|(a, b)| a.merge(b));
        }
        self.sum_rule.merge(&other.sum_rule);
        self.uniform_g.merge(&other.uniform_g);
        self.uniform_k.merge(&other.uniform_k);
    }
}
