use rand_distr::{Distribution, StandardNormal};
use sphvar_samplers::Streams;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::VariancePoint;

/// A crossing of the variance curves of two patterns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossover {
    /// The number of points at the crossing.
    pub n_points: f64,
    /// The end points of its 95 % interval.
    pub interval: (f64, f64),
    /// The adjacent numbers of points at which one of the curves is known.
    pub bracket: (f64, f64),
    /// The fraction of resampled curves that cross at all; well below 1, the crossing may be noise.
    pub confidence: f64,
    /// Whether the curves differ significantly on both sides, in opposite ways ([`crossovers`]).
    pub is_significant: bool,
    /// Whether the first curve lies below the second one beyond the crossing.
    pub first_is_better_above: bool,
}

/// The number of resampled pairs of curves from which an interval is computed.
const RESAMPLES: u64 = 1000;

/// The probability of a reported crossing for a pair of curves that do not cross.
const FALSE_ALARM: f64 = 0.01;

/// Returns the last crossing of two variance curves within the range of N that both cover, or
/// `None` if they do not cross there. Curves that only touch, or meet at an end, do not cross. Each
/// curve is sorted by N and has positive variances.
///
/// The result is the last of the significant [`crossovers`] if there are any; otherwise it is the
/// last crossing, which may be noise.
#[must_use]
pub fn crossover(a: &[VariancePoint], b: &[VariancePoint], streams: Streams) -> Option<Crossover> {
    let pair = Pair::new(a, b)?;
    if let Some(&(from, to)) = pair.significant_changes().last() {
        return pair.crossing(from, to, true, streams);
    }
    pair.crossing(0, pair.knots.len() - 1, false, streams)
}

/// Returns all significant crossings of two variance curves, by increasing number of points.
///
/// Curves are interpolated linearly in log N and log Var. A crossing is significant if on each side
/// of it there is a number of points at which the curves differ by more than their errors allow,
/// with opposite signs. With K numbers at which one of the curves is known, the threshold is the
/// one-sided normal quantile of `0.01/K`, so that a crossing is reported for at most 1 % of the
/// pairs that do not cross. If nearly equal curves cross several times between two such numbers,
/// the middle one of these crossings is returned, since the last one would be biased to large N.
///
/// The interval is computed from 1000 pairs of curves whose log variances are drawn about the given
/// ones with their relative standard errors (a parametric bootstrap). It is widened by the shift of
/// the crossing that the curvature between known points allows, and by at least half a point on
/// each side.
#[must_use]
pub fn crossovers(a: &[VariancePoint], b: &[VariancePoint], streams: Streams) -> Vec<Crossover> {
    let Some(pair) = Pair::new(a, b) else {
        return Vec::new();
    };
    let changes = pair.significant_changes();
    changes.into_iter().filter_map(|(from, to)| pair.crossing(from, to, true, streams)).collect()
}

/// Two curves, with the abscissas in their common range at which one is known.
struct Pair {
    a: Curve,
    b: Curve,
    knots: Vec<f64>,
}

impl Pair {
    fn new(a: &[VariancePoint], b: &[VariancePoint]) -> Option<Self> {
        let (a, b) = (Curve::new(a), Curve::new(b));
        if a.0.len() < 2 || b.0.len() < 2 {
            return None;
        }
        let from = a.0[0].0.max(b.0[0].0);
        let to = a.0[a.0.len() - 1].0.min(b.0[b.0.len() - 1].0);
        let mut knots: Vec<f64> =
            a.0.iter().chain(&b.0).map(|p| p.0).filter(|x| (from..=to).contains(x)).collect();
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        (knots.len() >= 2).then_some(Self { a, b, knots })
    }

    /// Returns the pairs of knots, in order, between which the difference of the curves changes
    /// sign significantly.
    fn significant_changes(&self) -> Vec<(usize, usize)> {
        let critical = -Normal::standard().inverse_cdf(FALSE_ALARM / self.knots.len() as f64);
        let decided = self.knots.iter().enumerate().filter_map(|(i, &x)| {
            let difference = self.a.at(x) - self.b.at(x);
            let stderr = self.a.error_at(x).hypot(self.b.error_at(x));
            // The logarithms of exact variances have rounding errors.
            let is_significant = difference.abs() > critical * stderr && difference.abs() > 1e-12;
            is_significant.then_some((i, difference > 0.0))
        });
        let decided: Vec<(usize, bool)> = decided.collect();
        let changes = decided.windows(2).filter(|w| w[0].1 != w[1].1);
        changes.map(|w| (w[0].0, w[1].0)).collect()
    }

    /// Returns the crossing between two knots: the middle one if the ends are significantly
    /// different, otherwise the last.
    fn crossing(
        &self,
        from: usize,
        to: usize,
        is_significant: bool,
        streams: Streams,
    ) -> Option<Crossover> {
        let knots = &self.knots[from..=to];
        let pick = |found: &[(f64, bool)]| {
            if is_significant { found.get(found.len() / 2).copied() } else { found.last().copied() }
        };
        let (at, first_is_better_above) = pick(&crossings(&self.a, &self.b, knots))?;
        let mut n_crossing = 0_u64;
        let mut resampled: Vec<f64> = (0..RESAMPLES)
            .filter_map(|i| {
                let mut rng = streams.realization(i);
                let mut normal = || StandardNormal.sample(&mut rng);
                let (a, b) = (self.a.perturbed(&mut normal), self.b.perturbed(&mut normal));
                n_crossing += u64::from(!crossings(&a, &b, &self.knots).is_empty());
                pick(&crossings(&a, &b, knots)).map(|c| c.0)
            })
            .collect();
        resampled.sort_by(f64::total_cmp);
        let quantile = |q: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an index below RESAMPLES"
            )]
            let index = (q * (resampled.len().saturating_sub(1)) as f64).round() as usize;
            resampled.get(index).copied().unwrap_or(at)
        };
        let above = self.knots.partition_point(|x| *x <= at).clamp(1, self.knots.len() - 1);
        let bracket = (self.knots[above - 1], self.knots[above]);
        let bend = self.bend_error(at, bracket);
        let (low, high) = (quantile(0.025).min(at), quantile(0.975).max(at));
        // Curvature moves the crossing only between the neighbouring knots.
        let low = (low - bend).max(low.min(bracket.0)).exp().min(at.exp() - 0.5);
        let high = (high + bend).min(high.max(bracket.1)).exp().max(at.exp() + 0.5);
        Some(Crossover {
            n_points: at.exp(),
            interval: (low.max(1.0).min(at.exp()), high),
            bracket: (bracket.0.exp(), bracket.1.exp()),
            confidence: n_crossing as f64 / RESAMPLES as f64,
            is_significant,
            first_is_better_above,
        })
    }

    /// Returns the maximum distance, in log N, between the crossing and that of the straight lines:
    /// the largest deviation of a parabola from its chord, an eighth of its second difference, over
    /// the difference of the slopes.
    fn bend_error(&self, at: f64, bracket: (f64, f64)) -> f64 {
        let height = self.a.bend_at(at).hypot(self.b.bend_at(at));
        let difference = |x: f64| self.a.at(x) - self.b.at(x);
        let slope = (difference(bracket.1) - difference(bracket.0)) / (bracket.1 - bracket.0);
        if height > 0.0 { height / slope.abs() } else { 0.0 }
    }
}

/// A variance curve given by points (ln N, ln Var, relative error).
struct Curve(Vec<(f64, f64, f64)>);

impl Curve {
    fn new(points: &[VariancePoint]) -> Self {
        let row = |p: &VariancePoint| (p.n_points.ln(), p.variance.ln(), p.stderr / p.variance);
        Self(points.iter().map(row).collect())
    }

    fn perturbed(&self, normal: &mut dyn FnMut() -> f64) -> Self {
        Self(self.0.iter().map(|&(x, y, e)| (x, y + e * normal(), e)).collect())
    }

    /// Returns the index of the right end of the segment that contains `x`, which lies within the
    /// curve.
    fn piece(&self, x: f64) -> usize {
        self.0.partition_point(|p| p.0 < x).clamp(1, self.0.len() - 1)
    }

    /// Returns the ordinate at `x`.
    fn at(&self, x: f64) -> f64 {
        let i = self.piece(x);
        let ((x0, y0, _), (x1, y1, _)) = (self.0[i - 1], self.0[i]);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    }

    /// Returns the standard error of the ordinate at `x`.
    fn error_at(&self, x: f64) -> f64 {
        let i = self.piece(x);
        let ((x0, _, e0), (x1, _, e1)) = (self.0[i - 1], self.0[i]);
        let share = (x - x0) / (x1 - x0);
        ((1.0 - share) * e0).hypot(share * e1)
    }

    /// Returns the larger deviation at `x` from the chord of the parabolas through its ends and a
    /// further point. A deviation within the errors of the points counts as 0.
    fn bend_at(&self, x: f64) -> f64 {
        let i = self.piece(x);
        let ((x0, y0, e0), (x1, y1, e1)) = (self.0[i - 1], self.0[i]);
        let chord = (y1 - y0) / (x1 - x0);
        let further = [i.checked_sub(2), Some(i + 1)].into_iter().flatten();
        let bends = further.filter_map(|k| self.0.get(k)).map(|&(x2, y2, e2)| {
            let off = y2 - y0 - chord * (x2 - x0);
            let allowed = 2.0 * e2.hypot(e0).hypot(e1);
            let second = (off.abs() - allowed).max(0.0) / ((x2 - x0) * (x2 - x1));
            second * (x1 - x0) * (x1 - x0) / 4.0
        });
        bends.fold(0.0, f64::max)
    }
}

/// Returns the abscissas of all crossings between knots, in order, and whether `a` is the lower
/// curve beyond each.
///
/// If the curves coincide at knots between two at which they differ with opposite signs, the last
/// such knot is the crossing.
fn crossings(a: &Curve, b: &Curve, knots: &[f64]) -> Vec<(f64, bool)> {
    let mut found = Vec::new();
    let mut before: Option<(f64, f64)> = None;
    let mut touch = None;
    for &x in knots {
        let d = a.at(x) - b.at(x);
        match before {
            _ if d == 0.0 => touch = Some(x),
            Some((x0, d0)) if d * d0 < 0.0 => {
                found.push((touch.unwrap_or(x0 + (x - x0) * d0 / (d0 - d)), d < 0.0));
                (before, touch) = (Some((x, d)), None);
            }
            _ => (before, touch) = (Some((x, d)), None),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Purpose, Streams};

    use super::{VariancePoint, crossover, crossovers};

    fn power_law(ns: &[f64], c: f64, slope: f64, relative: f64) -> Vec<VariancePoint> {
        let point = |&n: &f64| {
            let variance = c * n.powf(slope);
            VariancePoint { n_points: n, variance, stderr: relative * variance }
        };
        ns.iter().map(point).collect()
    }

    #[test]
    fn power_laws_cross_at_the_exact_point() {
        // 1/N and 100/N^2 meet at N = 100, independent of the grids on which they are known.
        let a = power_law(&[12.0, 48.0, 192.0, 768.0], 1.0, -1.0, 0.02);
        let b = power_law(&[10.0, 60.0, 500.0], 100.0, -2.0, 0.02);
        let got = crossover(&a, &b, Streams::new(0, Purpose::Resample, 0)).unwrap();
        assert!((got.n_points - 100.0).abs() < 1e-9, "{got:?}");
        assert!(got.interval.0 < 100.0 && got.interval.1 > 100.0, "{got:?}");
        assert!(got.interval.0 > 85.0 && got.interval.1 < 118.0, "{got:?}");
        assert!(got.confidence > 0.999 && !got.first_is_better_above, "{got:?}");
    }

    /// Curves that coincide at one knot or along several knots, and curves that only touch.
    #[test]
    fn a_crossing_at_a_knot_is_found() {
        let curve = |variances: [f64; 5]| -> Vec<VariancePoint> {
            let points = variances.iter().enumerate();
            points
                .map(|(i, &variance)| VariancePoint {
                    n_points: 4f64.powi(i32::try_from(i).unwrap() + 1),
                    variance,
                    stderr: 0.0,
                })
                .collect()
        };
        let at = |a, b| crossover(&curve(a), &curve(b), Streams::new(0, Purpose::Resample, 0));
        let level = [4.0; 5];
        // At the third knot, N = 64, in both orders.
        let falling = [16.0, 8.0, 4.0, 2.0, 1.0];
        let got = at(falling, level).unwrap();
        assert!((got.n_points - 64.0).abs() < 1e-12 && got.first_is_better_above, "{got:?}");
        let got = at(level, falling).unwrap();
        assert!((got.n_points - 64.0).abs() < 1e-12 && !got.first_is_better_above, "{got:?}");
        // The curves coincide from the second to the fourth knot: the crossing is the last of
        // these.
        let got = at([8.0, 4.0, 4.0, 4.0, 2.0], level).unwrap();
        assert!((got.n_points - 256.0).abs() < 1e-10, "{got:?}");
        // Touching, or meeting at an end, is not a crossing.
        assert!(at([8.0, 4.0, 8.0, 8.0, 8.0], level).is_none());
        assert!(at([8.0, 8.0, 8.0, 8.0, 4.0], level).is_none());
        // A later touch does not hide an earlier crossing.
        let got = at([8.0, 2.0, 2.0, 4.0, 2.0], level).unwrap();
        assert!(got.n_points > 4.0 && got.n_points < 16.0, "{got:?}");
    }

    #[test]
    fn parallel_curves_do_not_cross() {
        let a = power_law(&[12.0, 48.0], 1.0, -1.0, 0.0);
        let b = power_law(&[12.0, 48.0], 2.0, -1.0, 0.0);
        assert!(crossover(&a, &b, Streams::new(0, Purpose::Resample, 0)).is_none());
        assert!(crossover(&a, &b[..1], Streams::new(0, Purpose::Resample, 0)).is_none());
    }

    /// A crossing is rarely reported for curves that coincide, or that differ at one end only. It
    /// is reported for curves that cross at N = 170 with errors of 4.5 %, and the middle crossings
    /// lie on both sides of that value.
    #[test]
    fn noise_is_not_a_crossing_and_crossings_are_unbiased() {
        const SEEDS: u64 = 400;
        let ns = [48.0, 108.0, 192.0, 432.0, 768.0, 1728.0, 3072.0];
        let perturbed = |curve: &dyn Fn(f64) -> f64, seed: u64| -> Vec<VariancePoint> {
            use rand_distr::{Distribution, StandardNormal};
            let mut rng = Streams::new(seed, Purpose::Trial, 0).realization(0);
            let point = |&n: &f64| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                let variance = curve(n) * (0.045 * normal).exp();
                VariancePoint { n_points: n, variance, stderr: 0.045 * variance }
            };
            ns.iter().map(point).collect()
        };
        let found = |a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64| {
            let of = |seed: u64| {
                let (a, b) = (perturbed(a, 2 * seed), perturbed(b, 2 * seed + 1));
                crossovers(&a, &b, Streams::new(seed, Purpose::Resample, 0))
            };
            (0..SEEDS).map(of).collect::<Vec<_>>()
        };
        let white = |n: f64| 1.0 / n;
        // The stated rate is 1 %; five standard errors of it are 2.5 %.
        let apart = |n: f64| (1.0 + 0.002 * n) / n;
        for other in [&white as &dyn Fn(f64) -> f64, &apart] {
            let alarms = found(&white, other).iter().filter(|c| !c.is_empty()).count();
            assert!(alarms as f64 <= 0.035 * SEEDS as f64, "{alarms}");
        }
        let jitter = |n: f64| 170f64.sqrt() * n.powf(-1.5);
        let crossing: Vec<_> = found(&jitter, &white).into_iter().flatten().collect();
        assert!(crossing.len() as f64 > 0.99 * SEEDS as f64, "{}", crossing.len());
        let above = crossing.iter().filter(|c| c.n_points > 170.0).count();
        // Half of the crossings are expected above; five standard errors are an eighth.
        let half = 0.5 * crossing.len() as f64;
        assert!((above as f64 - half).abs() < 50.0, "{above} of {}", crossing.len());
        let held = crossing.iter().filter(|c| c.interval.0 <= 170.0 && 170.0 <= c.interval.1);
        assert!(held.count() as f64 > 0.9 * crossing.len() as f64);
    }

    #[test]
    fn every_crossing_is_returned_and_has_a_width() {
        let curve = |f: &dyn Fn(f64) -> f64| -> Vec<VariancePoint> {
            (0..8)
                .map(|i| 10.0 * 2f64.powi(i))
                .map(|n| VariancePoint { n_points: n, variance: f(n), stderr: 0.0 })
                .collect()
        };
        let wave = curve(&|n: f64| (1.0 + 0.3 * (1.5 * n.ln()).sin()) / n);
        let white = curve(&|n: f64| 1.0 / n);
        let got = crossovers(&wave, &white, Streams::new(0, Purpose::Resample, 0));
        // 1.5 ln N = k pi between 10 and 1280.
        let exact = [65.97, 535.7].map(f64::from);
        let near =
            got.iter().filter(|c| exact.iter().any(|x| c.interval.0 <= *x && *x <= c.interval.1));
        assert!(near.count() >= 2, "{got:?}");
        for c in &got {
            assert!(
                c.interval.1 - c.interval.0 >= 1.0 && c.bracket.1 >= c.bracket.0 + 1.0,
                "{c:?}"
            );
            assert!(c.interval.0 <= c.n_points && c.n_points <= c.interval.1, "{c:?}");
        }
    }
}
