//! Student's distribution, which is the normal distribution where a standard error is known
//! exactly.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Returns the quantile of probability `p` of Student's distribution with `dof` degrees of freedom,
/// the normal one if `dof` is infinite; NaN
/// unless `dof` is positive.
#[must_use]
pub fn student_quantile(p: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    if dof == f64::INFINITY {
        return Normal::standard().inverse_cdf(p);
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| t.inverse_cdf(p))
}

/// Returns the probability of a value at least as far from 0 as `t` on either side; NaN unless
/// `dof` is positive.
pub(crate) fn two_sided(t: f64, dof: f64) -> f64 {
    if dof == f64::INFINITY {
        return (2.0 * Normal::standard().sf(t.abs())).min(1.0);
    }
    StudentsT::new(0.0, 1.0, dof)
        .map_or(f64::NAN, |distribution| (2.0 * distribution.sf(t.abs())).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::{student_quantile, two_sided};

    /// Tables: t(0.975; 1) = 12.7062, t(0.975; 10) = 2.22814, z(0.975) = 1.95996.
    #[test]
    fn quantiles_are_those_of_tables() {
        for (dof, expected) in [(1.0, 12.7062), (10.0, 2.22814), (f64::INFINITY, 1.95996)] {
            assert!((student_quantile(0.975, dof) / expected - 1.0).abs() < 1e-5, "{dof}");
            assert!((two_sided(-expected, dof) / 0.05 - 1.0).abs() < 1e-4, "{dof}");
        }
    }

    #[test]
    fn quantiles_without_degrees_of_freedom_are_nan() {
        assert!(student_quantile(1.5, 3.0).is_nan() && student_quantile(f64::NAN, 3.0).is_nan());
        for dof in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(student_quantile(0.975, dof).is_nan() && two_sided(1.0, dof).is_nan(), "{dof}");
        }
    }
}
