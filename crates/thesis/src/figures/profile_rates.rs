use sphvar_bounds::{IntegrandClass, Profile};
use sphvar_samplers::Domain;
use sphvar_variance::{VariancePoint, fit_rate};

use crate::{Claim, Quantity, Stated};

/// The range of N for the slope of a rate.
pub(crate) const FAR: [usize; 3] = [1_000_000, 10_000_000, 100_000_000];
/// Tolerance of the slope between finite N from a rate printed with one decimal.
const TOLERANCE: f64 = 0.005;

/// Returns the claim that the variance of a class of integrands falls with this rate if the
/// spectrum is the profile. Closed forms decide it; `erratum` is about factors of the formula,
/// which do not affect the rate.
pub(crate) fn rate_claim(
    what: &str,
    class: IntegrandClass,
    profile: &Profile,
    rate: f64,
    erratum: u8,
) -> Claim {
    let point = |&n: &usize| VariancePoint {
        n_points: n as f64,
        variance: class.variance(profile, n, Domain::Sphere),
        stderr: 0.0,
    };
    let points: Vec<VariancePoint> = FAR.iter().map(point).collect();
    let slope = fit_rate(&points).map_or(f64::NAN, |fit| fit.slope);
    Claim::number(
        format!("rate of the {what}"),
        Stated::About { value: rate, tolerance: TOLERANCE },
        Quantity::exact(slope),
    )
    .erratum(erratum)
    .because("closed form between N = 1e6 and 1e8; the erratum changes factors, not the rate")
}
