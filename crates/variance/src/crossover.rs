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
/// `None` if they do not cross there; touching is not crossing, nor is meeting at the end. Each curve is
/// sorted by N and has positive variances.
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
    // From the right, the last two knots at which the curves differ, in opposite ways; where they meet
    // exactly at knots between these, the last such knot is the crossing.
    let mut beyond: Option<(f64, f64)> = None;
    let mut touch = None;
    for &x in knots.iter().rev() {
        let d = a.at(x) - b.at(x);
        match beyond {
            _ if d == 0.0 => touch = touch.or(beyond.map(|_| x)),
            Some((x1, d1)) if d * d1 < 0.0 => {
                return Some((touch.unwrap_or(x + (x1 - x) * d / (d - d1)), d1 < 0.0));
            }
            _ => {
                beyond = Some((x, d));
                touch = None;
            }
        }
    }
    None
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

    /// Curves that meet exactly at a knot, along a whole stretch of knots, or only touch.
    #[test]
    fn a_crossing_at_a_knot_is_seen() {
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
        // At the third knot, N = 64; both ways round.
        let falling = [16.0, 8.0, 4.0, 2.0, 1.0];
        let got = at(falling, level).unwrap();
        assert!((got.n_points - 64.0).abs() < 1e-12 && got.first_is_better_above, "{got:?}");
        let got = at(level, falling).unwrap();
        assert!((got.n_points - 64.0).abs() < 1e-12 && !got.first_is_better_above, "{got:?}");
        // From the second to the fourth knot they are one curve: the crossing is where that ends.
        let got = at([8.0, 4.0, 4.0, 4.0, 2.0], level).unwrap();
        assert!((got.n_points - 256.0).abs() < 1e-10, "{got:?}");
        // Touching is not crossing, and neither is meeting at an end.
        assert!(at([8.0, 4.0, 8.0, 8.0, 8.0], level).is_none());
        assert!(at([8.0, 8.0, 8.0, 8.0, 4.0], level).is_none());
        // An earlier crossing is not hidden by a later touch.
        let got = at([8.0, 2.0, 2.0, 4.0, 2.0], level).unwrap();
        assert!(got.n_points > 4.0 && got.n_points < 16.0, "{got:?}");
    }

    #[test]
    fn parallel_curves_do_not_cross() {
        let a = law(&[12.0, 48.0], 1.0, -1.0, 0.0);
        let b = law(&[12.0, 48.0], 2.0, -1.0, 0.0);
        assert!(crossover(&a, &b, Streams::new(0, Purpose::Resample, 0)).is_none());
        assert!(crossover(&a, &b[..1], Streams::new(0, Purpose::Resample, 0)).is_none());
    }
}
