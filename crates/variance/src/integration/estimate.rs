use sphvar_samplers::Domain;

use super::level::CopySums;
use crate::{Error, Measurement};

/// The minimum number of evaluations over which the variation of a function must be spread. With
/// fewer, the distribution of estimates is skewed, and all copies may miss the largest values.
const MIN_EFFECTIVE: f64 = 64.0;

/// Relative rounding error of the values of a function and of their sums.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// An integral and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimated integral.
    pub value: f64,
    /// The half width of the interval that contains the integral with the requested confidence:
    /// Student's quantile times the standard error, plus the rounding error of sums.
    pub error: f64,
}

/// An estimate with what decides whether its error is valid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    pub(super) estimate: Estimate,
    /// The part of the error that is due to rounding.
    rounding: f64,
    /// `(sum |d|)^2/sum d^2` over all evaluations, with d the difference from the mean: about the
    /// number of evaluations over which the variation is spread.
    effective: f64,
    is_constant: bool,
}

impl Judged {
    /// Returns whether enough evaluations contribute to the variation.
    pub(super) fn is_resolved(&self) -> bool {
        self.effective >= MIN_EFFECTIVE
    }

    /// Returns whether all values are equal within their rounding.
    pub(super) fn is_constant(&self) -> bool {
        self.is_constant
    }

    /// Returns whether the spread of the estimates is within the rounding error.
    pub(super) fn is_limited_by_rounding(&self) -> bool {
        self.estimate.error <= 2.0 * self.rounding
    }
}

/// Returns the estimate of each component from the copies of one level.
///
/// # Errors
///
/// Returns [`Error::Integrand`] if an integral exceeds the range of numbers.
pub(super) fn estimates(
    copies: &[Vec<CopySums>],
    components: usize,
    domain: Domain,
    quantile: f64,
) -> Result<Vec<Judged>, Error> {
    (0..components)
        .map(|c| {
            let of_component: Vec<CopySums> = copies.iter().map(|copy| copy[c]).collect();
            judge(&of_component, domain.area(), quantile)
        })
        .collect()
}

fn judge(copies: &[CopySums], area: f64, quantile: f64) -> Result<Judged, Error> {
    let max = |number: fn(&CopySums) -> f64| copies.iter().map(number).fold(0.0, f64::max);
    let (largest, max_deviation) = (max(|s| s.largest), max(|s| s.max_deviation));
    if largest <= 0.0 {
        let estimate = Estimate { value: 0.0, error: 0.0 };
        return Ok(Judged { estimate, rounding: 0.0, effective: 0.0, is_constant: true });
    }
    let relative = |s: &CopySums| s.largest / largest;
    let means = Measurement::new(copies.iter().map(|s| s.mean * relative(s)).collect());
    let magnitude = copies.iter().map(|s| s.mean_magnitude * relative(s)).sum::<f64>();
    let rounding = ROUNDING * magnitude / copies.len() as f64;
    let stderr = means.mean_stderr();
    let scaled_error = quantile * stderr + rounding;
    let estimate =
        Estimate { value: means.mean() * largest * area, error: scaled_error * largest * area };
    if !(estimate.value.is_finite() && estimate.error.is_finite()) {
        let reason = "its integral exceeds the range of numbers, about 1.8e308".to_owned();
        return Err(sphvar_integrands::Error::Evaluation { reason }.into());
    }
    // Sets of one point vary only from copy to copy, and have no deviation within a copy.
    let is_constant = max_deviation <= ROUNDING * largest && stderr <= rounding;
    let (mut deviations, mut squares) = (0.0, 0.0);
    if max_deviation > ROUNDING * largest {
        for s in copies {
            let ratio = s.max_deviation / max_deviation;
            deviations += s.deviations * ratio;
            squares += s.squares * ratio * ratio;
        }
    }
    let effective = if squares > 0.0 { deviations * deviations / squares } else { 0.0 };
    Ok(Judged { estimate, rounding: rounding * largest * area, effective, is_constant })
}
