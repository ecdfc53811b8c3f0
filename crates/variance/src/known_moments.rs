use sphvar_samplers::PointSet;

use crate::space::IntegrationSpace;
use crate::{Measurement, RelativeError, rarest_seen};

/// Properties of the distribution of estimates that are known without any trial.
///
/// Every point of a homogeneous pattern is uniformly distributed, so every even moment of the mean
/// over N points is at most that of a single value (Jensen). An integrand that few of N points hit
/// is hit by equally few points of any pattern with well separated points as by those of white
/// noise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct KnownMoments {
    /// The number N of equally weighted points whose sum has the same kurtosis if single points hit
    /// the integrand: [`SumsOfWeights::equal_points`] of given sets, otherwise the number of points.
    pub(crate) n_points: f64,
    /// The variance of the estimate from independent points with the weights of the sets.
    pub(crate) independent_variance: f64,
    /// The variance of the estimate from a single point.
    pub(crate) one_point_variance: f64,
    /// The kurtosis of the integrand's values.
    pub(crate) kurtosis: Option<f64>,
    /// The kurtosis of the estimate from a single point.
    pub(crate) one_point_kurtosis: Option<f64>,
    /// Whether the points are independent.
    pub(crate) is_independent: bool,
}

impl KnownMoments {
    /// Returns the moments of the sum of independent estimates, one of each; those of the only one.
    ///
    /// Each sum over N points with the variance `s^2/N` has the fourth cumulant `(k - 3) s^4/N^3`,
    /// and cumulants add. The result has the same kurtosis of rarely hit values,
    ///
    /// ```text
    /// k/N = sum_i k_i s_i^4/N_i^3/V^2,   V = sum_i s_i^2/N_i,   N = V^2/sum_i s_i^4/N_i^3,
    /// ```
    ///
    /// and `one_point` moments of the sum of one value of each.
    pub(crate) fn of_sum(parts: &[Self]) -> Self {
        if let [single] = parts {
            return *single;
        }
        // Relative to the largest variance, so that no power overflows.
        let variance = parts.iter().map(|part| part.one_point_variance).fold(0.0, f64::max);
        let relative =
            |part: &Self| if variance > 0.0 { part.one_point_variance / variance } else { 0.0 };
        let sum = |term: &dyn Fn(&Self) -> f64| parts.iter().map(term).sum::<f64>();
        let of_sets = sum(&|part| relative(part) / part.n_points);
        let quartic = |part: &Self| relative(part).powi(2) / part.n_points.powi(3);
        let is_known = |part: &Self| part.kurtosis.is_some() || part.one_point_variance <= 0.0;
        let is_known = parts.iter().all(is_known);
        let with_kurtosis = |part: &Self| part.kurtosis.map_or(0.0, |k| k * quartic(part));
        let squares = sum(&relative).powi(2);
        let fourth = sum(&|part| part.one_point_kurtosis.unwrap_or(0.0) * relative(part).powi(2));
        let pairs = 3.0 * (squares - sum(&|part| relative(part).powi(2)));
        Self {
            n_points: of_sets.powi(2) / sum(&quartic),
            independent_variance: parts.iter().map(|part| part.independent_variance).sum(),
            one_point_variance: sum(&|part| part.one_point_variance),
            kurtosis: is_known.then(|| sum(&with_kurtosis) / sum(&quartic)),
            one_point_kurtosis: is_known.then(|| (fourth + pairs) / squares),
            is_independent: parts.iter().all(|part| part.is_independent),
        }
    }

    /// Returns the exact relative standard error of the variance of n estimates with independent
    /// points: `r^2 = 2/(n - 1) + (k - 3)/(n N)` for the kurtosis k of values. Returns `None` where
    /// it is unknown.
    pub(crate) fn exact_error(&self, trials: usize) -> Option<f64> {
        let n = trials as f64;
        let excess = (self.kurtosis.filter(|_| self.is_independent)? - 3.0) / self.n_points;
        Some((2.0 / (n - 1.0) + excess / n).sqrt()).filter(|r| r.is_finite())
    }

    /// Returns the error measured from trials, but at least the known one: that of
    /// [`exact_error`](Self::exact_error), otherwise that of [`rare_error`](Self::rare_error).
    pub(crate) fn error(&self, measurement: &Measurement) -> RelativeError {
        let trials = measurement.estimates().len();
        let rare = || self.rare_error(measurement.variance(), trials);
        measurement.relative_error().at_least(self.exact_error(trials).unwrap_or_else(rare))
    }

    /// Returns the relative standard error that values hit by few sets give the variance of n
    /// estimates, if the true variance is V: `r^2 = e/n` for their excess kurtosis e
    /// ([`rare_excess`](Self::rare_excess)).
    pub(crate) fn rare_error(&self, variance: f64, trials: usize) -> f64 {
        (self.rare_excess(variance) / trials as f64).sqrt()
    }

    /// Returns the excess kurtosis of estimates of the variance V that is due to values hit by at
    /// most about one of N points, which have the fourth moment of independent points:
    ///
    /// ```text
    /// e = k/N (V_0/V)^2 - 3   for k > 3 N,   otherwise 0
    /// ```
    ///
    /// `V_0` is the variance with independent points. Stratification reduces V by the broad part of
    /// an integrand, but not the fourth moment, so the rare values decide about what is left. A
    /// variance above `V_0` counts as `V_0`.
    fn rare_excess(&self, variance: f64) -> f64 {
        let Some(of_independent) = self.kurtosis.map(|k| k / self.n_points).filter(|k| *k > 3.0)
        else {
            return 0.0;
        };
        // Without a variance there is nothing to compare with.
        let reduction = self.independent_variance / variance;
        let reduction = if reduction.is_finite() { reduction.max(1.0) } else { 1.0 };
        of_independent * reduction * reduction - 3.0
    }

    /// Returns the number of trials at which the known error of a variance is `relative`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates, and NaN needs no trials"
    )]
    pub(crate) fn trials_for(&self, relative: f64, variance: f64) -> u64 {
        (self.rare_excess(variance) / (relative * relative)) as u64
    }

    /// Returns the 97.5 % upper limit of the variance where all trials gave the same estimate,
    /// which differs by `offset` from the integral if that is known.
    ///
    /// Other estimates have a probability of at most q = [`rarest_seen`], so by the Cauchy-Schwarz
    /// inequality
    ///
    /// ```text
    /// Var <= E[(x - x_0)^2; x != x_0] <= sqrt(q E (x - x_0)^4),   E (x - x_0)^4 <= (k^(1/4) s_1 + |offset|)^4
    /// ```
    ///
    /// with the variance `s_1^2` and the kurtosis k of a single point. The limit never exceeds
    /// `s_1^2`.
    pub(crate) fn limit_unseen(&self, trials: usize, offset: Option<f64>) -> f64 {
        let by_trials = self.one_point_kurtosis.zip(offset).map(|(kurtosis, offset)| {
            let norm = kurtosis.sqrt().sqrt() * self.one_point_variance.sqrt() + offset.abs();
            rarest_seen(trials).sqrt() * norm * norm
        });
        by_trials.map_or(self.one_point_variance, |limit| limit.min(self.one_point_variance))
    }
}

/// The mean sums of powers of the weights of given sets, one of which is drawn uniformly: over the
/// different points of a set, as coincident points are hit together, and with `sum_i w_i = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SumsOfWeights {
    /// `mean_sets sum_i w_i^2`, the variance of the mean of independent values of variance 1.
    pub(crate) squares: f64,
    fourths: f64,
}

impl SumsOfWeights {
    /// Returns the sums of sets; `None` without sets.
    pub(crate) fn of<S: IntegrationSpace>(sets: &[PointSet<S::Point>]) -> Option<Self> {
        if sets.is_empty() {
            return None;
        }
        let (mut squares, mut fourths) = (0.0, 0.0);
        for set in sets {
            let weights = weights_of_places::<S>(set);
            let sum: f64 = weights.iter().sum();
            squares += weights.iter().map(|w| (w / sum).powi(2)).sum::<f64>();
            fourths += weights.iter().map(|w| (w / sum).powi(4)).sum::<f64>();
        }
        let count = sets.len() as f64;
        Some(Self { squares: squares / count, fourths: fourths / count })
    }

    /// Returns the number N of equally weighted points for which the mean of rarely hit values has
    /// the kurtosis k/N that it has for the sets, `N = (mean sum_i w_i^2)^2/mean sum_i w_i^4`.
    ///
    /// It is the number of points for sets of equally many, equally weighted and different ones,
    /// and close to 1 where one weight exceeds all others together.
    pub(crate) fn equal_points(self) -> f64 {
        self.squares * self.squares / self.fourths
    }
}

/// Returns the total weights of the different points of a set, relative to the largest weight.
fn weights_of_places<S: IntegrationSpace>(set: &PointSet<S::Point>) -> Vec<f64> {
    let largest = set.weights.iter().fold(0.0_f64, |max, w| max.max(w.abs()));
    let weight = |k: usize| set.weights.get(k).map_or(1.0, |w| w / largest);
    // The sign of a zero does not distinguish points.
    let key = |k: usize| S::coordinates(&set.points[k]).map(|x| (x + 0.0).to_bits());
    let mut order: Vec<_> = (0..set.len()).map(|k| (key(k), k)).collect();
    order.sort_unstable();
    let places = order.chunk_by(|a, b| a.0 == b.0);
    places.map(|place| place.iter().map(|&(_, k)| weight(k)).sum()).collect()
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{PointSet, Square};

    use super::{KnownMoments, SumsOfWeights};

    fn one_value(variance: f64, kurtosis: f64) -> KnownMoments {
        KnownMoments {
            n_points: 1.0,
            independent_variance: variance,
            one_point_variance: variance,
            kurtosis: Some(kurtosis),
            one_point_kurtosis: Some(kurtosis),
            is_independent: true,
        }
    }

    /// Two independent sums, of 5 and of 20 values that are 1 with probabilities 0.2 and 0.05: the
    /// fourth central moment of their sum is that of the cumulants of binomial counts,
    /// `N p q (1 - 6 p q)`.
    #[test]
    fn moments_of_sums_are_those_of_added_cumulants() {
        let parts = [(0.2f64, 5.0f64), (0.05, 20.0)];
        let of = |&(p, n): &(f64, f64)| {
            let q = 1.0 - p;
            KnownMoments { n_points: n, ..one_value(p * q, 3.0 + (1.0 - 6.0 * p * q) / (p * q)) }
        };
        let cumulants = |size: &dyn Fn(f64) -> f64| {
            let each =
                |f: &dyn Fn(f64, f64) -> f64| parts.iter().map(|&(p, n)| f(p, n)).sum::<f64>();
            // Of means of N values: the sum over `size` values, each divided by it.
            let second = each(&|p, n| p * (1.0 - p) / size(n));
            let pq = |p: f64| p * (1.0 - p);
            let fourth = each(&|p, n| pq(p) * (1.0 - 6.0 * pq(p)) / size(n).powi(3));
            fourth / second.powi(2)
        };
        let sum = KnownMoments::of_sum(&parts.iter().map(of).collect::<Vec<_>>());
        let excess = (sum.kurtosis.unwrap() - 3.0) / sum.n_points;
        assert!((excess / cumulants(&|n| n) - 1.0).abs() < 1e-12, "{sum:?}");
        let excess = sum.one_point_kurtosis.unwrap() - 3.0;
        assert!((excess / cumulants(&|_| 1.0) - 1.0).abs() < 1e-12, "{sum:?}");
        assert_eq!(KnownMoments::of_sum(&[of(&parts[0])]), of(&parts[0]));
    }

    fn line(weights: &[f64]) -> PointSet<[f64; 2]> {
        let points = (0..weights.len()).map(|k| [k as f64 / weights.len() as f64, 0.5]).collect();
        PointSet { points, weights: weights.to_vec() }
    }

    #[test]
    fn equal_points_follow_from_the_fourth_powers_of_weights() {
        let of = |sets: &[PointSet<[f64; 2]>]| {
            SumsOfWeights::of::<Square>(sets).map(SumsOfWeights::equal_points)
        };
        assert_eq!(of(&[]), None);
        let close = |sets: &[PointSet<[f64; 2]>], expected: f64| {
            let got = of(sets).unwrap();
            assert!((got / expected - 1.0).abs() < 1e-14, "{got}, {expected}");
        };
        for scale in [1.0, -3.0, 1e-200, 1e300] {
            close(&[line(&[scale; 7])], 7.0);
            // Squares 9 + 1 + 1, fourth powers 81 + 1 + 1.
            close(&[line(&[3.0 * scale, scale, -scale])], 121.0 / 83.0);
        }
        close(&[PointSet::new(line(&[1.0; 5]).points)], 5.0);
        // The mean of sets of 1 and 4 points: squares 1 + 1/4, fourth powers 1 + 1/64.
        close(&[line(&[1.0]), line(&[1.0; 4])], 1.25f64.powi(2) / (2.0 * (1.0 + 1.0 / 64.0)));
        // Three of five points coincide.
        let points = vec![[0.0, 0.5], [0.1, 0.5], [-0.0, 0.5], [0.2, 0.5], [0.0, 0.5]];
        close(&[PointSet::new(points)], 121.0 / 83.0);
    }

    /// For a value that is 1 with probability p and 0 otherwise, all n trials give 0 only if p is
    /// below 3.7/n (at 97.5 %); the variance p (1 - p) has the corresponding limit.
    #[test]
    fn the_limit_holds_for_every_cap_that_may_be_unseen() {
        for n in [10, 1000, 100_000] {
            for share in [0.01, 0.3, 1.0] {
                let p: f64 = share * super::rarest_seen(n);
                let kurtosis = (1.0 - p).powi(2) / p + p * p / (1.0 - p);
                let known = one_value(p * (1.0 - p), kurtosis);
                let limit = known.limit_unseen(n, Some(p));
                assert!(limit >= p * (1.0 - p), "{n}, {share}: {limit}");
                assert!((known.limit_unseen(n, None) - p * (1.0 - p)).abs() < 1e-15);
            }
        }
    }

    /// A value c of probability p beside a function of variance b^2 that stratification integrates
    /// without error. Of N points at most one hits the value, so the sum has the variance
    /// `p c^2/N` and the kurtosis `1/(N p)`, up to the order of `N p`.
    #[test]
    fn stratification_leaves_the_fourth_moment_of_rare_values() {
        let (p, n, trials) = (1e-6f64, 50.0, 1000);
        for (value, broad) in [(2000.0f64, 0.0f64), (2000.0, 3.0), (200.0, 1.0)] {
            let rare = p * value.powi(2);
            let variance = rare + broad.powi(2);
            let kurtosis = p * value.powi(4) / variance.powi(2);
            let independent_variance = variance / n;
            let one = one_value(variance, kurtosis);
            let of = KnownMoments { n_points: n, independent_variance, ..one };
            let expected = (1.0 / (n * p) - 3.0) / trials as f64;
            if kurtosis > 3.0 * n {
                let got = of.rare_error(rare / n, trials).powi(2);
                assert!((got / expected - 1.0).abs() < 1e-3, "{value}, {broad}: {got}, {expected}");
            }
            // A clumped pattern has at least the error of independent points.
            let independent = of.rare_error(independent_variance, trials);
            for other in [10.0 * independent_variance, 0.0] {
                assert!((of.rare_error(other, trials) - independent).abs() <= 1e-14 * independent);
            }
        }
        // All sets hit values of a small kurtosis, whatever their variance.
        let hit = KnownMoments { n_points: n, ..one_value(1.0, 100.0) };
        assert!(hit.rare_error(1e-9, trials) == 0.0 && hit.trials_for(0.1, 1e-9) == 0);
    }

    /// Binomial counts: Var s^2 of a single point follows from the moments for p (1 - p),
    /// `(mu_4 - s^4 (n-3)/(n-1))/n`.
    #[test]
    fn the_exact_error_is_that_of_the_fourth_moment() {
        let (p, n) = (0.2f64, 50);
        let variance = p * (1.0 - p);
        let fourth = p * (1.0f64 - p).powi(4) + (1.0 - p) * p.powi(4);
        let known = one_value(variance, fourth / variance.powi(2));
        let expected = ((fourth / variance.powi(2) - 47.0 / 49.0) / 50.0).sqrt();
        assert!((known.exact_error(n).unwrap() / expected - 1.0).abs() < 1e-12);
    }
}
