use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// A variance at a number of points, measured or predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Chi-square per degree of freedom of the fit; well above 1 where the variances do not follow
    /// one power law within their errors. NaN for exact variances or two points.
    pub chi2_per_dof: f64,
    /// By how much the local exponent changes from the smallest to the largest N, from a parabola in log
    /// N and log Var; NaN of fewer than three points, or four without errors.
    pub slope_change: f64,
    /// The probability of a change at least as large where the law is a power law.
    pub slope_change_p: f64,
}

impl RateFit {
    /// The false-alarm rate of [`Self::is_pre_asymptotic`].
    pub const FALSE_ALARM: f64 = 0.001;

    /// Whether the variances bend so much that the exponent is not the asymptotic one yet: the parabola's term is
    /// significant at 0.1 %, so that of a thousand power laws one is called bent: tables have many of them.
    #[must_use]
    pub fn is_pre_asymptotic(&self) -> bool {
        self.slope_change_p < Self::FALSE_ALARM
    }
}

/// The power law through `points` by least squares in log N and log Var, or `None` of fewer than
/// two usable points at different N.
///
/// Points are weighted by their relative errors; points of variance 0 are left out. If some error
/// is 0 or unknown, all points weigh the same and the interval comes from their scatter alone. With
/// scatter beyond the errors, as where the law is not a power yet, the interval is widened by it
/// (Student's t at the degrees of freedom of the fit).
#[must_use]
pub fn fit_rate(points: &[VariancePoint]) -> Option<RateFit> {
    let usable: Vec<_> =
        points.iter().filter(|p| p.variance > 0.0 && p.variance.is_finite()).collect();
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
    // Known errors have a normal quantile, errors from the scatter that of their few degrees of
    // freedom.
    let quantile = match StudentsT::new(0.0, 1.0, dof) {
        Ok(t) if scale > 1.0 || !weighted => t.inverse_cdf(0.975),
        _ => 1.959_963_984_540_054,
    };
    let half = quantile * (scale * variance_of_slope).sqrt();
    let (slope_change, slope_change_p) = bend(&rows, weighted);
    Some(RateFit {
        slope,
        interval: (slope - half, slope + half),
        intercept: y0 - slope * x0,
        chi2_per_dof: if weighted { chi2_per_dof } else { f64::NAN },
        slope_change,
        slope_change_p,
    })
}

/// The change of slope of the parabola through rows (x, y, weight) from the first to the last x, and the
/// probability of one as large by chance: normal where weights are known errors, else Student's t with
/// the scatter about the parabola.
///
/// The parabola's last term is `c q(x)` with q orthogonal to 1 and x under the weights, so
/// `c = <y q>/<q q>` has variance `1/<q q>` whatever the other two terms are.
fn bend(rows: &[(f64, f64, f64)], weighted: bool) -> (f64, f64) {
    let dof = rows.len() as f64 - 3.0;
    if dof < 0.0 || (!weighted && dof < 1.0) {
        return (f64::NAN, f64::NAN);
    }
    let total: f64 = rows.iter().map(|r| r.2).sum();
    let sum = |f: &dyn Fn(f64, f64) -> f64| rows.iter().map(|r| r.2 * f(r.0, r.1)).sum::<f64>();
    let (x0, y0) = (sum(&|x, _| x) / total, sum(&|_, y| y) / total);
    let moment = |k: i32| sum(&|x, _| (x - x0).powi(k));
    let (second, slope) = (moment(2), sum(&|x, y| (x - x0) * (y - y0)) / moment(2));
    let skew = moment(3) / second;
    let q = |x: f64| (x - x0) * (x - x0) - skew * (x - x0) - second / total;
    let norm = sum(&|x, _| q(x) * q(x));
    // With all points at two different N there is no parabola.
    if norm <= 1e-12 * moment(4) {
        return (f64::NAN, f64::NAN);
    }
    let line = |x: f64, y: f64| y - y0 - slope * (x - x0);
    let c = sum(&|x, y| q(x) * line(x, y)) / norm;
    let ends = |f: fn(f64, f64) -> f64, from| rows.iter().map(|r| r.0).fold(from, f);
    let span = ends(f64::max, f64::NEG_INFINITY) - ends(f64::min, f64::INFINITY);
    // Logarithms round by some EPSILON of 10: what is below that is a straight line.
    if c.abs() * (norm / total).sqrt() <= 1e-13 {
        return (2.0 * c * span, 1.0);
    }
    let z = c.abs() * norm.sqrt();
    let p = if weighted {
        2.0 * Normal::standard().sf(z)
    } else {
        let scatter = sum(&|x, y| (line(x, y) - c * q(x)).powi(2)) / dof;
        StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| 2.0 * t.sf(z / scatter.sqrt()))
    };
    (2.0 * c * span, p)
}

#[cfg(test)]
mod tests {
    use super::{VariancePoint, fit_rate};

    fn law(slope: f64, stderr: f64) -> Vec<VariancePoint> {
        [12.0f64, 48.0, 192.0, 768.0]
            .iter()
            .map(|&n| {
                let variance = 3.0 * n.powf(slope);
                VariancePoint { n_points: n, variance, stderr: stderr * variance }
            })
            .collect()
    }

    #[test]
    fn a_power_law_is_found() {
        for stderr in [0.0, 0.01] {
            let fit = fit_rate(&law(-1.5, stderr)).unwrap();
            assert!((fit.slope + 1.5).abs() < 1e-13, "{fit:?}");
            assert!((fit.intercept - 3f64.ln()).abs() < 1e-12, "{fit:?}");
            assert!(fit.interval.0 <= -1.5 + 1e-12 && fit.interval.1 >= -1.5 - 1e-12, "{fit:?}");
        }
    }

    #[test]
    fn the_interval_of_known_errors_is_the_textbook_one() {
        let fit = fit_rate(&law(-1.0, 0.01)).unwrap();
        // x = ln 12 + {0, 1, 2, 3} ln 4: sum of squares about the mean 5 ln^2 4.
        let sigma = 0.01 / (5f64.sqrt() * 4f64.ln());
        let half = 0.5 * (fit.interval.1 - fit.interval.0);
        assert!((half / (1.959_963_984_540_054 * sigma) - 1.0).abs() < 1e-12, "{half}");
    }

    /// `Var = c N^(-1 + a ln N)` has the exponent `-1 + 2 a ln N`: a change of `2 a ln 64` over these points.
    #[test]
    fn a_bend_is_the_change_of_the_exponent() {
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
            let straight = fit_rate(&law(-1.5, stderr)).unwrap();
            assert!(!straight.is_pre_asymptotic() && straight.slope_change.abs() < 1e-12);
            // Three points have a parabola, but no scatter about it.
            let few = fit_rate(&points[..3]).unwrap();
            assert!(few.slope_change.is_nan() == (stderr == 0.0), "{few:?}");
            assert!(!fit_rate(&points[..2]).unwrap().is_pre_asymptotic());
        }
    }

    #[test]
    fn what_is_no_line_is_refused() {
        let points = law(-1.0, 0.1);
        assert!(fit_rate(&[]).is_none());
        assert!(fit_rate(&points[..1]).is_none());
        assert!(fit_rate(&[points[0], points[0]]).is_none());
        let zero = VariancePoint { variance: 0.0, ..points[1] };
        assert!(fit_rate(&[points[0], zero]).is_none());
    }
}
