//! Integration to a requested tolerance.
//!
//! At each level, [`COPIES`] independently rotated sets of N points give that number of estimates,
//! which are unbiased and have the same variance, whatever the pattern. Their mean is the value,
//! and Student's distribution gives an interval from their spread. N doubles until the interval is
//! within the tolerance.
//!
//! A rule that stops at the first short interval selects small spreads, so the intervals that it
//! keeps contain the integral less often than all intervals do. Suppose that the estimates are
//! normal with standard deviation `sigma_k = sigma_0 2^(-p k)` at level k. With
//! `t` the quantile, R the number of copies, `a_k = tol sqrt(R)/(t sigma_k)` and `u` the measured
//! standard deviation in units of the true one, level k stops with probability `P(u <= a_k)`, and
//! the level that stops fails with probability
//!
//! ```text
//! sum_k prod_(j < k) P(u > a_j) int_0^(a_k) 2 Phi(-t u) dP(u).
//! ```
//!
//! The largest failure over `a_0` for R = 16 and the 95 % quantile is 7.2 % for p = 1/2, which is the
//! rate of independent points and a lower bound of that of useful patterns, and 6.5 % for fast
//! convergence. With half the probability of error at each level it is 3.9 and 3.4 %, so each level
//! uses that quantile. A test evaluates the sum.

mod estimate;
mod level;
mod options;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_integrands::{Integrand, VectorIntegrand};
use sphvar_samplers::{PointSet, Progress, Purpose, Realizations, Sampler, Streams};

pub use self::estimate::Estimate;
use self::estimate::{Judged, estimates};
use self::level::{CopySums, Range, copy_sums};
pub use self::options::IntegrationOptions;
use crate::Error;
use crate::estimates::{Single, evaluation_work};

/// The number of randomly rotated copies of a set at each level. Student's factor and the
/// correction for the choice of the level are within a quarter of those of infinitely many copies;
/// more copies have larger errors than larger sets with the same total number of points.
pub(crate) const COPIES: usize = 16;

/// The number of points of the first sets.
const FIRST_COUNT: usize = 32;

/// The reason why an integration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopReason {
    /// Every error is within the tolerance.
    Tolerance,
    /// The errors that exceed the tolerance are due to rounding, which more points do not reduce.
    Rounding,
    /// The next level would exceed the maximum number of evaluations.
    MaxPoints,
    /// The pattern has no larger sets.
    LargestSet,
    /// All values are equal, at as many points as the limits allow, so that the error is unknown:
    /// the function may be constant, or differ on less than [`Integral::unseen_share`] of the
    /// domain. With several components, those that miss the tolerance have equal values.
    EqualValues,
}

/// An integral with its error, and how it was obtained.
#[derive(Clone, Debug, PartialEq)]
pub struct Integral {
    /// Value and error of each component, one for a scalar function.
    pub estimates: Vec<Estimate>,
    /// The number N of points of each copy at the last level.
    pub n_points: usize,
    /// The number of copies of the set at each level, each with its own rotation.
    pub copies: usize,
    /// The number of evaluations of the function at all levels.
    pub evaluations: u64,
    /// The reason why the last level is the last.
    pub stop: StopReason,
}

impl Integral {
    /// Returns the value of the first component.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.estimates.first().map_or(f64::NAN, |estimate| estimate.value)
    }

    /// Returns the error of the first component; see [`Estimate::error`].
    #[must_use]
    pub fn error(&self) -> f64 {
        self.estimates.first().map_or(f64::NAN, |estimate| estimate.error)
    }

    /// Returns `3.7/evaluations`, at most 1: independent points all miss a feature that covers this
    /// share of the domain with probability 2.5 %.
    #[must_use]
    pub fn unseen_share(&self) -> f64 {
        const MISSED: f64 = 0.025;
        (-MISSED.ln() / self.evaluations as f64).min(1.0)
    }

    /// Returns whether every component meets the tolerance.
    #[must_use]
    pub fn has_converged(&self) -> bool {
        self.stop == StopReason::Tolerance
    }
}

/// Returns the integral of `f` over the domain to a tolerance.
///
/// At each level the value is the mean over 16 independently rotated copies of a set of N points.
/// N starts at about 32 and doubles (to the nearest valid count) until
/// `error <= max(atol, rtol |value|)`, where the error includes the correction for stopping at the
/// first such level. An error is known if the variance of the values is spread over at least 16
/// evaluations and no earlier level has much more different values; otherwise it is NaN, and N
/// doubles further. It is therefore never known for values that are all equal.
///
/// The confidence holds for bounded functions whose features the points hit; no rule that evaluates
/// a function finds a feature that no point hits (see [`Integral::unseen_share`]). Estimates near singularities such as `r^-1/2` are
/// skewed, and their intervals contain the integral less often than stated.
///
/// The result is a function of the options and of `f` alone, whatever the number of threads.
/// Announces the work of every level to `progress` and ticks it.
///
/// # Errors
///
/// - [`Error::Parameter`] for invalid options;
/// - [`Error::Integrand`] if `f` cannot be evaluated, or a value is not finite, with the direction;
/// - [`Error::Spectrum`] with the error of the sampler if sets cannot be generated or `progress`
///   stops the work.
///
/// A tolerance that is not met is not an error: see [`Integral::stop`].
///
/// # Examples
///
/// ```
/// use sphvar_variance::{IntegrationOptions, integrate};
///
/// let options = IntegrationOptions { rtol: 1e-5, ..Default::default() };
/// let integral = integrate(&|d: glam::DVec3| d.x.exp(), &options, &())?;
/// let exact = 4.0 * std::f64::consts::PI * 1f64.sinh();
/// assert!((integral.value() - exact).abs() <= integral.error() && integral.has_converged());
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
///
/// # References
///
/// Owen 2013, *Monte Carlo theory, methods and examples*, chapter 17 (replicated randomized
/// quasi-Monte Carlo).
pub fn integrate(
    f: &dyn Integrand,
    options: &IntegrationOptions<'_>,
    progress: &dyn Progress,
) -> Result<Integral, Error> {
    integrate_vector(&Single(f), options, progress)
}

/// Returns the integrals of all components of `f`, from the same points, as [`integrate`] does.
///
/// Every component must meet the tolerance. The confidence of an error is that of its component,
/// not of all components together.
///
/// # Errors
///
/// Returns the errors of [`integrate`], and [`Error::Parameter`] for a function without components.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::Integrand;
/// use sphvar_variance::{IntegrationOptions, integrate_vector};
///
/// let moments: Vec<Box<dyn Integrand>> =
///     vec![Box::new(|d: DVec3| d.x.max(0.0)), Box::new(|d: DVec3| d.z * d.z)];
/// let options = IntegrationOptions { rtol: 1e-3, ..Default::default() };
/// let integral = integrate_vector(&moments, &options, &())?;
/// assert!((integral.estimates[1].value / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
pub fn integrate_vector(
    f: &dyn VectorIntegrand,
    options: &IntegrationOptions<'_>,
    progress: &dyn Progress,
) -> Result<Integral, Error> {
    options.check()?;
    let components = f.components();
    if components == 0 {
        let name = "the number of components";
        return Err(Error::Parameter { name, range: "at least 1", got: 0.0 });
    }
    let quantile = options.quantile();
    let mut n_points = options.first_count()?;
    let mut evaluations = 0;
    let mut ranges = vec![Range::EMPTY; components];
    loop {
        let copies = level(f, options, n_points, progress)?;
        evaluations += (COPIES * n_points) as u64;
        let estimates = estimates(&copies, &mut ranges, options.domain, quantile)?;
        let integral = |stop| Integral {
            estimates: estimates.iter().map(|judged| judged.estimate).collect(),
            n_points,
            copies: COPIES,
            evaluations,
            stop,
        };
        let missed: Vec<&Judged> =
            estimates.iter().filter(|judged| !options.is_met(judged.estimate)).collect();
        if missed.is_empty() {
            return Ok(integral(StopReason::Tolerance));
        }
        if missed.iter().all(|judged| judged.is_limited_by_rounding()) {
            return Ok(integral(StopReason::Rounding));
        }
        // The reason of an integration that the limits end.
        let limited = |limit| {
            let is_constant = missed.iter().all(|judged| judged.is_constant());
            integral(if is_constant { StopReason::EqualValues } else { limit })
        };
        let Some(next) = options.next_count(n_points) else {
            return Ok(limited(StopReason::LargestSet));
        };
        let is_affordable = (COPIES as u64)
            .checked_mul(next as u64)
            .and_then(|more| more.checked_add(evaluations))
            .is_some_and(|total| total <= options.max_points);
        if !is_affordable {
            return Ok(limited(StopReason::MaxPoints));
        }
        n_points = next;
    }
}

/// Returns the sums of each copy of the set of `n_points` points.
fn level(
    f: &dyn VectorIntegrand,
    options: &IntegrationOptions<'_>,
    n_points: usize,
    progress: &dyn Progress,
) -> Result<Vec<Vec<CopySums>>, Error> {
    let sampler = options.sampler(n_points)?;
    let work = sampler.nominal_work() + evaluation_work(n_points * f.components());
    progress.expect(COPIES as f64 * work);
    let sets = realizations(&*sampler, options.seed);
    let copy = |(set, values): &mut (PointSet, Vec<f64>), index| {
        sets.realize_into(index, set, progress)?;
        copy_sums(f, set, values, progress)
    };
    // All copies are completed, so that an error is that of the first one for any number of
    // threads.
    let copies: Vec<Result<_, Error>> =
        (0..COPIES as u64).into_par_iter().map_init(Default::default, copy).collect();
    copies.into_iter().collect()
}

/// Returns the rotated copies of a set: realizations 0 to 15 of the pattern with this seed.
fn realizations(sampler: &dyn Sampler, seed: u64) -> Realizations<'_> {
    let streams = Streams::new(seed, Purpose::Pattern, sampler.stream_group());
    Realizations::rotated(sampler, streams)
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal};

    use super::{COPIES, IntegrationOptions};

    /// Returns the probability of stopping at a level whose interval does not contain the integral;
    /// see the module.
    fn failure(quantile: f64, rate: f64, first: f64) -> f64 {
        let degrees = COPIES as f64 - 1.0;
        let chi = ChiSquared::new(degrees).unwrap();
        let normal = Normal::standard();
        // u^2 (R - 1) has a chi-squared distribution; 400 midpoints are accurate to 1e-5.
        let density = |u: f64| chi.pdf(degrees * u * u) * 2.0 * degrees * u;
        let (mut running, mut failed, mut bound) = (1.0, 0.0, first);
        while running > 1e-9 {
            let step = f64::min(bound, 4.0) / 400.0;
            let fails = |i| {
                let u = step * (f64::from(i) + 0.5);
                step * density(u) * 2.0 * normal.sf(quantile * u)
            };
            failed += running * (0..400).map(fails).sum::<f64>();
            running *= chi.sf(degrees * bound * bound);
            bound *= 2f64.powf(rate);
        }
        failed
    }

    /// Half the probability of error at each level suffices for errors that fall as N^-1/2 or
    /// faster, at every confidence; the whole probability does not.
    #[test]
    fn the_level_that_stops_holds_with_the_stated_confidence() {
        let largest = |quantile, rate: f64| {
            let firsts = (0..6).map(|i| 2f64.powf(-3.0 + rate * f64::from(i) / 6.0));
            firsts.map(|first| failure(quantile, rate, first)).fold(0.0, f64::max)
        };
        for confidence in [0.9, 0.95, 0.99] {
            let options = IntegrationOptions { confidence, ..Default::default() };
            let allowed = 1.0 - confidence;
            for rate in [0.5, 0.75, 1.5, 4.0] {
                let got = largest(options.quantile(), rate);
                assert!((0.5 * allowed..allowed).contains(&got), "{confidence}, {rate}: {got}");
                let plain = crate::student_quantile(1.0 - allowed / 2.0, COPIES as f64 - 1.0);
                assert!(largest(plain, rate) > allowed, "{confidence}, {rate}");
            }
        }
    }
}
