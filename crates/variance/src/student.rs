//! Student's distribution, which is the normal distribution where a standard error is known
//! exactly.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// The degrees of freedom from which the approximation of Wallace is used, with a relative error of
/// about dof^-2. The iterated inverse has errors that grow with `dof`, to 4e-5 here, and for some
/// numbers far beyond it does not end.
const MANY: f64 = 1e6;

/// Returns the quantile of probability `p` of Student's distribution with `dof` degrees of freedom,
/// the normal one if `dof` is infinite; NaN unless `dof` is positive.
///
/// # References
///
/// Wallace 1959, "Bounds on normal approximations to Student's and the chi-square distributions".
#[must_use]
pub fn student_quantile(p: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    if dof == f64::INFINITY {
        return Normal::standard().inverse_cdf(p);
    }
    if dof >= MANY {
        let z = Normal::standard().inverse_cdf(p) / wallace_factor(dof);
        return ((z * z / dof).exp_m1() * dof).sqrt().copysign(z);
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| t.inverse_cdf(p))
}

/// Returns the factor of `sqrt(dof ln(1 + t^2/dof))` that makes it a normal variable.
fn wallace_factor(dof: f64) -> f64 {
    (1.0 + 0.125 / dof) / (1.0 + 0.375 / dof)
}

/// Returns the probability of a value at least as far from 0 as `t` on either side; NaN unless
/// `dof` is positive.
pub(crate) fn two_sided(t: f64, dof: f64) -> f64 {
    if dof == f64::INFINITY {
        return (2.0 * Normal::standard().sf(t.abs())).min(1.0);
    }
    if dof >= MANY {
        let z = wallace_factor(dof) * ((t * t / dof).ln_1p() * dof).sqrt();
        return two_sided(z, f64::INFINITY);
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

    /// Both functions are continuous where the approximation begins, and normal in the limit; the
    /// inverse of the incomplete beta function does not end at some of these numbers.
    #[test]
    fn many_degrees_of_freedom_are_almost_normal() {
        for p in [0.5, 0.6, 0.975, 0.9999, 0.01] {
            let normal = student_quantile(p, f64::INFINITY);
            let (below, above) = (student_quantile(p, 0.999e6), student_quantile(p, 1.001e6));
            // The iterated inverse has an error of up to 4e-5 here.
            assert!((below - above).abs() < 1e-4, "{p}: {below} {above}");
            let expected = normal + (normal.powi(3) + normal) / 4e6;
            assert!((student_quantile(p, 1e6) - expected).abs() < 1e-10, "{p}");
            for dof in [1e6, 1e10, 1e16, 1e17, 1e20, 1e30, 1e300, f64::MAX] {
                let quantile = student_quantile(p, dof);
                assert!((quantile - normal).abs() < 1e-4, "{p} {dof:e}: {quantile}");
                let both = two_sided(quantile, dof) - 2.0 * p.min(1.0 - p);
                assert!(both.abs() < 1e-10, "{p} {dof:e}: {both:e}");
            }
        }
        assert!((two_sided(2.0, 0.999e6) - two_sided(2.0, 1.001e6)).abs() < 1e-8);
    }

    #[test]
    fn quantiles_without_degrees_of_freedom_are_nan() {
        assert!(student_quantile(1.5, 3.0).is_nan() && student_quantile(f64::NAN, 3.0).is_nan());
        for dof in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(student_quantile(0.975, dof).is_nan() && two_sided(1.0, dof).is_nan(), "{dof}");
        }
    }
}
