use sphvar_samplers::Domain;

use super::level::{CopySums, Range};
use crate::{Error, Measurement};

/// The minimum number of evaluations over which the variance of a function must be spread. With
/// fewer, the distribution of estimates is skewed, and all copies may miss the largest values.
const MIN_EFFECTIVE: f64 = 16.0;

/// Values seen at earlier levels may be this many times as widely spread as those of a level. The
/// spread of a bounded function that the points resolve changes by less.
const MAX_HIDDEN: f64 = 2.0;

/// The error of values and of their sums, relative to the mean magnitude of the values: the error of
/// a common factor or term, such as a constant, does not average out.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The error of values relative to the largest magnitude, which is that of a function whose terms
/// cancel or whose values are computed together, as by a Fourier transform.
const ROUNDING_OF_LARGEST: f64 = f64::EPSILON;

/// An integral and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimated integral.
    pub value: f64,
    /// The half width of the interval that contains the integral with the requested confidence:
    /// Student's quantile times the standard error, plus the rounding error of values and sums.
    /// NaN where the values do not determine it: all are equal, or too few contribute to their
    /// variance.
    pub error: f64,
}

/// An estimate with what decides whether its error is valid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    pub(super) estimate: Estimate,
    /// The part of the error that is due to rounding.
    rounding: f64,
    is_constant: bool,
}

impl Judged {
    /// Returns whether all values of all levels are equal within their rounding.
    pub(super) fn is_constant(&self) -> bool {
        self.is_constant
    }

    /// Returns whether the spread of the estimates is within the rounding error.
    pub(super) fn is_limited_by_rounding(&self) -> bool {
        self.estimate.error <= 2.0 * self.rounding
    }
}

/// Returns the estimate of each component from the copies of one level. `ranges` has the ranges of
/// the components at the earlier levels, and is extended by that of this level.
///
/// # Errors
///
/// Returns [`Error::Integrand`] if an integral exceeds the range of numbers.
pub(super) fn estimates(
    copies: &[Vec<CopySums>],
    ranges: &mut [Range],
    domain: Domain,
    quantile: f64,
) -> Result<Vec<Judged>, Error> {
    let judge_component = |(c, range)| {
        let of_component: Vec<CopySums> = copies.iter().map(|copy| copy[c]).collect();
        judge(&of_component, range, domain.area(), quantile)
    };
    ranges.iter_mut().enumerate().map(judge_component).collect()
}

fn judge(
    copies: &[CopySums],
    range: &mut Range,
    area: f64,
    quantile: f64,
) -> Result<Judged, Error> {
    let of_level = copies.iter().fold(Range::EMPTY, |range, s| range.union(s.range));
    *range = range.union(of_level);
    let is_constant = range.half_width() <= ROUNDING * range.largest();
    let is_hidden = range.half_width() > MAX_HIDDEN * of_level.half_width();
    let largest = of_level.largest();
    if largest <= 0.0 {
        let estimate = Estimate { value: 0.0, error: f64::NAN };
        return Ok(Judged { estimate, rounding: 0.0, is_constant });
    }
    let relative = |s: &CopySums| s.range.largest() / largest;
    let means = Measurement::new(copies.iter().map(|s| s.mean * relative(s)).collect());
    let magnitude = copies.iter().map(|s| s.mean_magnitude * relative(s)).sum::<f64>();
    let rounding = ROUNDING * magnitude / copies.len() as f64 + ROUNDING_OF_LARGEST;
    let stderr = means.mean_stderr();
    let scaled_error = quantile * stderr + rounding;
    let mut estimate =
        Estimate { value: means.mean() * largest * area, error: scaled_error * largest * area };
    if !(estimate.value.is_finite() && estimate.error.is_finite()) {
        let reason = "its integral exceeds the range of numbers, about 1.8e308".to_owned();
        return Err(sphvar_integrands::Error::Evaluation { reason }.into());
    }
    if is_constant || is_hidden || effective(copies, largest) < MIN_EFFECTIVE {
        estimate.error = f64::NAN;
    }
    Ok(Judged { estimate, rounding: rounding * largest * area, is_constant })
}

/// Returns `(sum d^2)^2/sum d^4` over all evaluations, with d the difference from the mean: about
/// the number of evaluations over which the variance is spread. For a feature that is much narrower
/// than the domain, it is the number of points that hit the feature. It is 0 where the differences
/// are due to rounding; sets of one point have no differences.
fn effective(copies: &[CopySums], largest: f64) -> f64 {
    let max_deviation = copies.iter().map(|s| s.max_deviation).fold(0.0, f64::max);
    if max_deviation <= ROUNDING * largest {
        return 0.0;
    }
    let (mut squares, mut fourths) = (0.0, 0.0);
    for s in copies {
        let square = (s.max_deviation / max_deviation).powi(2);
        squares += s.squares * square;
        fourths += s.fourths * square * square;
    }
    squares * squares / fourths
}
