//! The time to generate a set.

use std::time::Instant;

use sphvar_samplers::SECONDS_PER_WORK;
use sphvar_variance::{CurvePredictor, PredictedCurve, PredictedVariance};

use super::choosable::{Choosable, MakeSet};
use crate::error::CliError;

/// The time to generate a set.
#[derive(Clone, Copy)]
pub(super) struct SetTime {
    pub(super) seconds: f64,
    /// Whether the time is scaled from a smaller set or taken from the cost model instead of
    /// measured at this number of points.
    pub(super) is_scaled: bool,
}

/// The number of sets that are generated for a median.
const TIMED_SETS: u64 = 5;
/// The time after which no further set is generated, in seconds.
const TIMED_SECONDS: f64 = 0.02;
/// The number of points of the largest set that is timed.
const MAX_TIMED_POINTS: usize = 10_000_000;
/// A set that is expected to take longer than this is not generated, in seconds: all patterns
/// together would take longer than their predictions.
const MAX_SET_SECONDS: f64 = 0.02;

/// Returns the time for a set of `n_points`, measured or scaled from the largest predicted set.
pub(super) fn set_time<P: Choosable>(
    curve: &PredictedCurve<P, P::Point>,
    predictor: &P::Predictor<'_>,
    n_points: usize,
    seed: u64,
) -> Result<SetTime, CliError> {
    let pattern = curve.pattern();
    let expected = |n: usize| SECONDS_PER_WORK * P::nominal_work(pattern, n);
    let largest = curve.points().last().map_or(n_points, P::Point::n_points);
    let too_long = largest < n_points && expected(n_points) > MAX_SET_SECONDS;
    let mut timed = if too_long { largest } else { n_points };
    if timed > MAX_TIMED_POINTS {
        timed = predictor.nearest_count(pattern, MAX_TIMED_POINTS);
    }
    if expected(timed) > MAX_SET_SECONDS {
        return Ok(SetTime { seconds: expected(n_points), is_scaled: true });
    }
    let is_scaled = timed < n_points;
    let seconds = median_seconds(pattern.make_set(timed, predictor, seed)?)?;
    Ok(SetTime { seconds: seconds * expected(n_points) / expected(timed), is_scaled })
}

/// Returns the median time for a set on one core, rotation or shift included.
fn median_seconds(mut make_set: MakeSet<'_>) -> Result<f64, CliError> {
    let mut seconds = Vec::new();
    for index in 0..TIMED_SETS {
        let started = Instant::now();
        make_set(index)?;
        seconds.push(started.elapsed().as_secs_f64());
        if seconds.iter().sum::<f64>() > TIMED_SECONDS {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[seconds.len() / 2])
}
