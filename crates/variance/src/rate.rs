use statrs::distribution::{ContinuousCDF, StudentsT};

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
    Some(RateFit {
        slope,
        interval: (slope - half, slope + half),
        intercept: y0 - slope * x0,
        chi2_per_dof: if weighted { chi2_per_dof } else { f64::NAN },
    })
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
