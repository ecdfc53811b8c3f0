use crate::student::{self, student_quantile};

/// A variance at a number of points, measured or predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VariancePoint {
    /// The number of points N.
    pub n_points: f64,
    /// The variance.
    pub variance: f64,
    /// Its standard error; 0 if it is exact.
    pub stderr: f64,
}

/// A power law `Var = c N^slope` fitted to variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateFit {
    /// The exponent: -1 for white noise.
    pub slope: f64,
    /// The end points of the exponent's 95 % confidence interval.
    pub interval: (f64, f64),
    /// The natural logarithm of c.
    pub intercept: f64,
    /// Chi-square per degree of freedom of the fit; well above 1 if the variances do not follow a
    /// power law within their errors. NaN for exact variances or two points.
    pub chi2_per_dof: f64,
    /// The change of the local exponent from the smallest to the largest N, from a parabola in log
    /// N and log Var; NaN for fewer than three points, or for fewer than four without errors.
    pub slope_change: f64,
    /// The probability of a change at least as large if the true curve is a power law; NaN for
    /// exact variances.
    pub slope_change_p: f64,
    is_bent: bool,
}

impl RateFit {
    /// The false-alarm rate of [`Self::is_pre_asymptotic`].
    pub const FALSE_ALARM: f64 = 0.001;

    /// Returns whether the curvature of the variances is so large that the exponent is not yet the
    /// asymptotic one.
    ///
    /// For [`fit_rate`] the quadratic term must be significant at 0.1 %, so that one of a thousand
    /// power laws is reported as curved; tables contain many rates. [`fit_exact_rate`] has its own
    /// criterion.
    #[must_use]
    pub fn is_pre_asymptotic(&self) -> bool {
        self.is_bent
    }
}

/// Returns the power law through predicted variances, whose errors are small relative to the
/// deviation of the curve from a power law. All points have equal weights, and the interval is
/// Student's from the scatter about the line.
///
/// The rate is called pre-asymptotic if the slope of the parabola through the points changes from
/// the smallest to the largest N by at least 0.1, by 3.3 times what the errors of the points allow
/// (0.1 % by chance) and, for more than three points, by three times what their scatter about the
/// parabola allows, since the curves of lattices scatter without curvature.
///
/// Returns `None` in the same cases as [`fit_rate`].
#[must_use]
pub fn fit_exact_rate(points: &[VariancePoint]) -> Option<RateFit> {
    let alike: Vec<_> = points.iter().map(|p| VariancePoint { stderr: 0.0, ..*p }).collect();
    let fit = fit_rate(&alike)?;
    let rows: Vec<(f64, f64, f64)> =
        usable(points).iter().map(|p| (p.n_points.ln(), p.variance.ln(), 1.0)).collect();
    let errors = usable(points).iter().map(|p| p.stderr / p.variance).collect::<Vec<_>>();
    let is_bent = Bend::new(&rows).is_some_and(|bend| {
        let change = bend.slope_change().abs();
        let by_errors = bend.stderr_by(&errors);
        let by_scatter = if bend.dof >= 1.0 { bend.stderr_by_scatter() } else { 0.0 };
        // A NaN is an unknown error and does not allow a verdict.
        change >= MIN_CHANGE && change >= 3.3 * by_errors && change >= 3.0 * by_scatter
    });
    Some(RateFit { is_bent, slope_change_p: f64::NAN, ..fit })
}

/// The smallest change of the exponent that is reported.
const MIN_CHANGE: f64 = 0.1;

/// Returns the points to which a power law can be fitted.
fn usable(points: &[VariancePoint]) -> Vec<&VariancePoint> {
    let is_usable = |p: &&VariancePoint| {
        p.variance > 0.0 && p.variance.is_finite() && p.stderr != f64::INFINITY
    };
    points.iter().filter(is_usable).collect()
}

/// Returns the power law through `points` by least squares in log N and log Var, or `None` for
/// fewer than two usable points at different N.
///
/// Points are weighted by their relative errors, which should not depend on the noise of the
/// variances. Points with variance 0 or an infinite error are left out. If some error is 0 or
/// unknown, all points have equal weights and the interval is computed from their scatter alone. If
/// the scatter exceeds the errors, as before the asymptotic range, the interval is widened
/// accordingly (Student's t with the degrees of freedom of the fit).
#[must_use]
pub fn fit_rate(points: &[VariancePoint]) -> Option<RateFit> {
    fit_rate_of_few(points, f64::INFINITY)
}

/// Returns [`fit_rate`] for variances whose standard errors were each estimated with `dof` degrees
/// of freedom, for example from `dof + 1` pictures. Student's quantiles with the degrees of freedom
/// of all points together replace the normal ones.
#[must_use]
pub fn fit_rate_of_few(points: &[VariancePoint], dof: f64) -> Option<RateFit> {
    let usable = usable(points);
    let known_dof = dof * usable.len() as f64;
    let weighted = usable.iter().all(|p| p.stderr > 0.0 && p.stderr.is_finite());
    let rows: Vec<(f64, f64, f64)> = usable
        .iter()
        .map(|p| {
            let relative = if weighted { p.stderr / p.variance } else { 1.0 };
            (p.n_points.ln(), p.variance.ln(), 1.0 / (relative * relative))
        })
        .collect();
    let total: f64 = rows.iter().map(|r| r.2).sum();
    let mean =
        |f: &dyn Fn(&(f64, f64, f64)) -> f64| rows.iter().map(|r| r.2 * f(r)).sum::<f64>() / total;
    let (x0, y0) = (mean(&|r| r.0), mean(&|r| r.1));
    let spread = mean(&|r| (r.0 - x0) * (r.0 - x0));
    if rows.len() < 2 || spread <= 1e-12 {
        return None;
    }
    let slope = mean(&|r| (r.0 - x0) * (r.1 - y0)) / spread;
    let dof = (rows.len() - 2) as f64;
    let chi2 = total * mean(&|r| (r.1 - y0 - slope * (r.0 - x0)).powi(2));
    let chi2_per_dof = if dof > 0.0 { chi2 / dof } else { f64::NAN };
    let variance_of_slope = 1.0 / (total * spread);
    let scale = match (weighted, dof > 0.0) {
        (true, true) => chi2_per_dof.max(1.0),
        (true, false) => 1.0,
        (false, true) => chi2_per_dof,
        (false, false) => f64::INFINITY,
    };
    // Errors estimated from the scatter have few degrees of freedom.
    let dof = if scale > 1.0 || !weighted { dof } else { known_dof };
    let error = (scale * variance_of_slope).sqrt();
    let half = if error.is_finite() { student_quantile(0.975, dof) * error } else { error };
    let (slope_change, slope_change_p) = bend(&rows, weighted.then_some(known_dof));
    Some(RateFit {
        slope,
        interval: (slope - half, slope + half),
        intercept: y0 - slope * x0,
        chi2_per_dof: if weighted { chi2_per_dof } else { f64::NAN },
        slope_change,
        slope_change_p,
        is_bent: slope_change_p < RateFit::FALSE_ALARM,
    })
}

/// The parabola through rows (x, y, weight), whose last term is `c q(x)` with q orthogonal to 1 and
/// x under the weights. `c = <y q>/<q q>` has the variance `1/<q q>`, independent of the other two
/// terms.
struct Bend {
    c: f64,
    /// `q` at the rows and its weighted square norm.
    q: Vec<f64>,
    norm: f64,
    /// Residuals from the parabola, with their weights.
    residuals: Vec<(f64, f64)>,
    span: f64,
    dof: f64,
}

impl Bend {
    /// Fits the parabola; `None` for fewer than three rows or three different x.
    fn new(rows: &[(f64, f64, f64)]) -> Option<Self> {
        let dof = rows.len() as f64 - 3.0;
        if dof < 0.0 {
            return None;
        }
        let total: f64 = rows.iter().map(|r| r.2).sum();
        let sum = |f: &dyn Fn(f64, f64) -> f64| rows.iter().map(|r| r.2 * f(r.0, r.1)).sum::<f64>();
        let (x0, y0) = (sum(&|x, _| x) / total, sum(&|_, y| y) / total);
        let moment = |k: i32| sum(&|x, _| (x - x0).powi(k));
        let (second, slope) = (moment(2), sum(&|x, y| (x - x0) * (y - y0)) / moment(2));
        let skew = moment(3) / second;
        let q = |x: f64| (x - x0) * (x - x0) - skew * (x - x0) - second / total;
        let norm = sum(&|x, _| q(x) * q(x));
        // Points at only two different N do not determine a parabola.
        if norm.is_nan() || norm <= 1e-12 * moment(4) {
            return None;
        }
        let line = |x: f64, y: f64| y - y0 - slope * (x - x0);
        let c = sum(&|x, y| q(x) * line(x, y)) / norm;
        // Logarithms of about 10 round by some EPSILON of it; a smaller term counts as a straight
        // line.
        let c = if c.abs() * (norm / total).sqrt() <= 1e-13 { 0.0 } else { c };
        let ends = |f: fn(f64, f64) -> f64, from| rows.iter().map(|r| r.0).fold(from, f);
        Some(Self {
            c,
            q: rows.iter().map(|r| q(r.0)).collect(),
            norm,
            residuals: rows.iter().map(|r| (line(r.0, r.1) - c * q(r.0), r.2)).collect(),
            span: ends(f64::max, f64::NEG_INFINITY) - ends(f64::min, f64::INFINITY),
            dof,
        })
    }

    /// Returns the change of slope from the first to the last x.
    fn slope_change(&self) -> f64 {
        2.0 * self.c * self.span
    }

    /// Returns the standard error of the change due to errors of y, with weights of 1.
    fn stderr_by(&self, errors: &[f64]) -> f64 {
        let sum: f64 = self.q.iter().zip(errors).map(|(q, e)| (q * e).powi(2)).sum();
        2.0 * self.span * sum.sqrt() / self.norm
    }

    /// Returns the standard error of the change from the scatter about the parabola.
    fn stderr_by_scatter(&self) -> f64 {
        let square: f64 = self.residuals.iter().map(|(r, w)| w * r * r).sum::<f64>() / self.dof;
        2.0 * self.span * (square / self.norm).sqrt()
    }
}

/// Returns the change of slope of the parabola through rows (x, y, weight) from the first to the
/// last x, and the probability of a change as large by chance. If the weights are from errors with
/// `known_dof` degrees of freedom together, the distribution is normal or Student's; otherwise it
/// is Student's t with the scatter about the parabola.
fn bend(rows: &[(f64, f64, f64)], known_dof: Option<f64>) -> (f64, f64) {
    let Some(bend) = Bend::new(rows).filter(|b| known_dof.is_some() || b.dof >= 1.0) else {
        return (f64::NAN, f64::NAN);
    };
    let change = bend.slope_change();
    if bend.c == 0.0 {
        return (change, 1.0);
    }
    let p = match known_dof {
        Some(dof) => student::two_sided(bend.c * bend.norm.sqrt(), dof),
        None => student::two_sided(change / bend.stderr_by_scatter(), bend.dof),
    };
    (change, p)
}

#[cfg(test)]
mod tests {
    use super::{VariancePoint, fit_exact_rate, fit_rate, fit_rate_of_few};

    fn power_law(slope: f64, stderr: f64) -> Vec<VariancePoint> {
        [12.0f64, 48.0, 192.0, 768.0]
            .iter()
            .map(|&n| {
                let variance = 3.0 * n.powf(slope);
                VariancePoint { n_points: n, variance, stderr: stderr * variance }
            })
            .collect()
    }

    #[test]
    fn a_power_law_is_recovered() {
        for stderr in [0.0, 0.01] {
            let fit = fit_rate(&power_law(-1.5, stderr)).unwrap();
            assert!((fit.slope + 1.5).abs() < 1e-13, "{fit:?}");
            assert!((fit.intercept - 3f64.ln()).abs() < 1e-12, "{fit:?}");
            assert!(fit.interval.0 <= -1.5 + 1e-12 && fit.interval.1 >= -1.5 - 1e-12, "{fit:?}");
        }
    }

    #[test]
    fn known_errors_give_the_textbook_interval() {
        let fit = fit_rate(&power_law(-1.0, 0.01)).unwrap();
        // x = ln 12 + {0, 1, 2, 3} ln 4: sum of squares about the mean 5 ln^2 4.
        let sigma = 0.01 / (5f64.sqrt() * 4f64.ln());
        let half = 0.5 * (fit.interval.1 - fit.interval.0);
        assert!((half / (1.959_963_984_540_054 * sigma) - 1.0).abs() < 1e-12, "{half}");
    }

    /// `Var = c N^(-1 + a ln N)` has the exponent `-1 + 2 a ln N`, which changes by `2 a ln 64`
    /// over these points.
    #[test]
    fn curvature_is_the_change_of_the_exponent() {
        for stderr in [0.0, 0.01] {
            let points: Vec<_> = [12.0f64, 48.0, 100.0, 192.0, 768.0]
                .iter()
                .map(|&n| {
                    let variance = n.powf(-1.0 + 0.02 * n.ln());
                    VariancePoint { n_points: n, variance, stderr: stderr * variance }
                })
                .collect();
            let fit = fit_rate(&points).unwrap();
            let expected = 0.04 * 64f64.ln();
            assert!((fit.slope_change - expected).abs() < 1e-12, "{fit:?}, {expected}");
            assert!(fit.is_pre_asymptotic(), "{fit:?}");
            let straight = fit_rate(&power_law(-1.5, stderr)).unwrap();
            assert!(!straight.is_pre_asymptotic() && straight.slope_change.abs() < 1e-12);
            // Three points determine a parabola, but no scatter about it.
            let few = fit_rate(&points[..3]).unwrap();
            assert!(few.slope_change.is_nan() == (stderr == 0.0), "{few:?}");
            assert!(!fit_rate(&points[..2]).unwrap().is_pre_asymptotic());
        }
    }

    #[test]
    fn degenerate_points_have_no_rate() {
        let points = power_law(-1.0, 0.1);
        assert!(fit_rate(&[]).is_none());
        assert!(fit_rate(&points[..1]).is_none());
        assert!(fit_rate(&[points[0], points[0]]).is_none());
        let zero = VariancePoint { variance: 0.0, ..points[1] };
        assert!(fit_rate(&[points[0], zero]).is_none());
    }

    /// Student's quantile with 4 points of 7 degrees of freedom each is 2.0484 (tables).
    #[test]
    fn errors_from_few_trials_use_students_quantile() {
        let points = power_law(-1.0, 0.01);
        let half = |fit: super::RateFit| 0.5 * (fit.interval.1 - fit.interval.0);
        let ratio = half(fit_rate_of_few(&points, 7.0).unwrap()) / half(fit_rate(&points).unwrap());
        assert!((ratio - 2.048_407 / 1.959_964).abs() < 1e-5, "{ratio}");
        let mut unusable = points.clone();
        unusable[0].stderr = f64::INFINITY;
        assert_eq!(fit_rate(&unusable), fit_rate(&points[1..]));
    }

    /// Jittering with disks of the area of a stratum, in degree 4: `1 - (2 J1(x)/x)^2` with
    /// `x = 8/sqrt N`. The exponent changes from -1.7 to -2. White noise is straight, and a lattice
    /// that scatters by 10 % about a power law is not curved.
    #[test]
    fn curvature_of_exact_curves_is_detected() {
        let curve = |powers: &[f64]| -> Vec<VariancePoint> {
            let ns = [12.0, 48.0, 192.0, 768.0];
            let point =
                |(n, p): (&f64, &f64)| VariancePoint { n_points: *n, variance: p / n, stderr: 0.0 };
            ns.iter().zip(powers).map(point).collect()
        };
        let bent = |powers: &[f64]| fit_exact_rate(&curve(powers)).unwrap().is_pre_asymptotic();
        let jitter = [0.781, 0.290, 0.0815, 0.0207];
        assert!(bent(&jitter));
        assert!(!bent(&[1.0; 4]) && !bent(&[0.9, 1.1, 0.95, 1.05]));
        // Errors of 30 % are too large for a verdict.
        let vague: Vec<_> = curve(&jitter)
            .into_iter()
            .map(|p| VariancePoint { stderr: 0.3 * p.variance, ..p })
            .collect();
        assert!(!fit_exact_rate(&vague).unwrap().is_pre_asymptotic());
    }
}
