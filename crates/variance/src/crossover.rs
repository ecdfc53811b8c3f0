use rand_distr::{Distribution, StandardNormal};
use sphvar_samplers::Streams;

use crate::VariancePoint;

/// Where the variance curves of two patterns cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossover {
    /// The number of points at the crossing.
    pub n_points: f64,
    /// The end points of its 95 % interval.
    pub interval: (f64, f64),
    /// The share of resampled curves that cross at all; well below 1, the crossing may be noise.
    pub confidence: f64,
    /// Whether the first curve lies below the second beyond the crossing.
    pub first_is_better_above: bool,
}

/// How many resampled pairs of curves an interval is taken from.
const RESAMPLES: u64 = 1000;

/// The last crossing of two variance curves within the numbers of points that both cover, or
/// `None` if they do not cross there. Each curve is sorted by N and has positive variances.
///
/// Curves are straight between their points in log N and log Var. The interval comes from
/// 1000 pairs of curves whose log variances are drawn about the given ones with their
/// relative standard errors (a parametric bootstrap).
#[must_use]
pub fn crossover(a: &[VariancePoint], b: &[VariancePoint], streams: Streams) -> Option<Crossover> {
    let (a, b) = (Curve::new(a), Curve::new(b));
    let (at, first_is_better_above) = last_crossing(&a, &b)?;
    let mut crossings: Vec<f64> = (0..RESAMPLES)
        .filter_map(|i| {
            let mut rng = streams.realization(i);
            let mut normal = || StandardNormal.sample(&mut rng);
            last_crossing(&a.shaken(&mut normal), &b.shaken(&mut normal)).map(|c| c.0)
        })
        .collect();
    crossings.sort_by(f64::total_cmp);
    let quantile = |q: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "an index below RESAMPLES"
        )]
        let index = (q * (crossings.len().saturating_sub(1)) as f64).round() as usize;
        crossings.get(index).copied().unwrap_or(at).exp()
    };
    let confidence = crossings.len() as f64 / RESAMPLES as f64;
    Some(Crossover {
        n_points: at.exp(),
        interval: (quantile(0.025), quantile(0.975)),
        confidence,
        first_is_better_above,
    })
}

/// A variance curve as points (ln N, ln Var, relative error).
struct Curve(Vec<(f64, f64, f64)>);

impl Curve {
    fn new(points: &[VariancePoint]) -> Self {
        let row = |p: &VariancePoint| (p.n_points.ln(), p.variance.ln(), p.stderr / p.variance);
        Self(points.iter().map(row).collect())
    }

    fn shaken(&self, normal: &mut dyn FnMut() -> f64) -> Self {
        Self(self.0.iter().map(|&(x, y, e)| (x, y + e * normal(), e)).collect())
    }

    /// The ordinate at `x`, which lies within the curve.
    fn at(&self, x: f64) -> f64 {
        let i = self.0.partition_point(|p| p.0 < x).clamp(1, self.0.len() - 1);
        let ((x0, y0, _), (x1, y1, _)) = (self.0[i - 1], self.0[i]);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    }
}

/// The abscissa of the last crossing, and whether `a` is the lower curve beyond it.
fn last_crossing(a: &Curve, b: &Curve) -> Option<(f64, bool)> {
    if a.0.len() < 2 || b.0.len() < 2 {
        return None;
    }
    let from = a.0[0].0.max(b.0[0].0);
    let to = a.0[a.0.len() - 1].0.min(b.0[b.0.len() - 1].0);
    let mut knots: Vec<f64> =
        a.0.iter().chain(&b.0).map(|p| p.0).filter(|x| (from..=to).contains(x)).collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    let difference = |x: f64| a.at(x) - b.at(x);
    knots.windows(2).rev().find_map(|pair| {
        let (d0, d1) = (difference(pair[0]), difference(pair[1]));
        let crosses = d0 * d1 < 0.0;
        crosses.then(|| (pair[0] + (pair[1] - pair[0]) * d0 / (d0 - d1), d1 < 0.0))
    })
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Purpose, Streams};

    use super::{VariancePoint, crossover};

    fn law(ns: &[f64], c: f64, slope: f64, relative: f64) -> Vec<VariancePoint> {
        let point = |&n: &f64| {
            let variance = c * n.powf(slope);
            VariancePoint { n_points: n, variance, stderr: relative * variance }
        };
        ns.iter().map(point).collect()
    }

    #[test]
    fn power_laws_cross_where_they_must() {
        // 1/N and 100/N^2 meet at N = 100, whatever grids they are known on.
        let a = law(&[12.0, 48.0, 192.0, 768.0], 1.0, -1.0, 0.02);
        let b = law(&[10.0, 60.0, 500.0], 100.0, -2.0, 0.02);
        let got = crossover(&a, &b, Streams::new(0, Purpose::Resample, 0)).unwrap();
        assert!((got.n_points - 100.0).abs() < 1e-9, "{got:?}");
        assert!(got.interval.0 < 100.0 && got.interval.1 > 100.0, "{got:?}");
        assert!(got.interval.0 > 85.0 && got.interval.1 < 118.0, "{got:?}");
        assert!(got.confidence > 0.999 && !got.first_is_better_above, "{got:?}");
    }

    #[test]
    fn parallel_curves_do_not_cross() {
        let a = law(&[12.0, 48.0], 1.0, -1.0, 0.0);
        let b = law(&[12.0, 48.0], 2.0, -1.0, 0.0);
        assert!(crossover(&a, &b, Streams::new(0, Purpose::Resample, 0)).is_none());
        assert!(crossover(&a, &b[..1], Streams::new(0, Purpose::Resample, 0)).is_none());
    }
}
