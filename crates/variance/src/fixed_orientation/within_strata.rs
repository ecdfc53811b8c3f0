use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, Progress};
use sphvar_sh::CompensatedSum;
use sphvar_spectrum::StrataQuadrature;

use crate::Error;
use crate::estimates::evaluation_work;
use sphvar_integrands::Integrand;

/// Returns the variance of a sum over strata with one independent uniform point each,
///
/// ```text
/// Var = (area/N)^2 sum_k Var_k F
/// ```
///
/// and the error of the quadrature: the difference from a rule for half the degree, which is large
/// where strata contain edges of F. Rules are made for twice `degree`, or for twice the largest
/// degree of F if that is smaller, because the variance is an integral of F^2.
pub(super) fn variance(
    strata: &StrataQuadrature,
    domain: Domain,
    integrand: &dyn Integrand,
    degree: usize,
    progress: &dyn Progress,
) -> Result<(f64, f64), Error> {
    let degree = integrand.band_limit().map_or(degree, |limit| limit.min(degree)).max(1);
    let mut sums = [0.0; 2];
    for (sum, degree) in sums.iter_mut().zip([2 * degree, degree]) {
        // In the order of the strata, so that the sum does not depend on threads.
        let of_stratum = |k: usize| within(strata, k, domain, integrand, degree, progress);
        let all: Vec<f64> =
            (0..strata.count()).into_par_iter().map(of_stratum).collect::<Result<_, Error>>()?;
        *sum = all.into_iter().collect::<CompensatedSum>().value();
    }
    let factor = (domain.area() / strata.count() as f64).powi(2);
    Ok((factor * sums[0], factor * (sums[0] - sums[1]).abs()))
}

/// Returns the variance of F at a uniform point of one stratum.
fn within(
    strata: &StrataQuadrature,
    k: usize,
    domain: Domain,
    integrand: &dyn Integrand,
    degree: usize,
    progress: &dyn Progress,
) -> Result<f64, Error> {
    let (mut points, weights) = strata.rule(k, degree)?;
    points.iter_mut().for_each(|p| *p = domain.representative(*p));
    let mut values = vec![0.0; points.len()];
    integrand.eval_into(&points, &mut values)?;
    progress.expect(evaluation_work(points.len()));
    progress.tick(evaluation_work(points.len()))?;
    let pairs = || weights.iter().zip(&values);
    let mean: f64 = pairs().map(|(w, v)| w * v).sum();
    Ok(pairs().map(|(w, v)| w * (v - mean).powi(2)).sum())
}
