//! A pattern at one number of points, for files and tables.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_variance::Comparison;

use super::rows::{Parts, Row};
use crate::patterns::UNPREDICTED;
use crate::report::{Column, number};

/// A pattern at one number of points, with its predicted and measured variance. A number that
/// cannot be given is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct RowRecord {
    /// The sampler with its parameters, as every command accepts it.
    sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    label: String,
    /// The integrand, as it was given; a channel or a product with a harmonic as every command
    /// accepts it, or `irradiance of` the integrand.
    integrand: String,
    /// The name of the integral in tables with several.
    #[serde(skip)]
    integral: Option<String>,
    /// `sphere`, `hemisphere` or `square`.
    domain: String,
    /// The number of points requested.
    n_requested: usize,
    /// The number of points.
    n: usize,
    /// The largest degree of the spectrum; on the square and for warped patterns the largest
    /// frequency, at most 256 if the spectrum is estimated. 0 with `--measure-only`.
    lmax: usize,
    /// Realizations from which the spectrum was estimated; 0 for a closed form and with
    /// `--measure-only`.
    realizations: u64,
    /// Trials from which the variance was measured; 0 with `--predict-only`.
    trials: usize,
    /// The predicted variance of the integral, in squared units of the integral; of an irradiance,
    /// the mean squared error integrated over all normals. Null for tessellations for a density and
    /// with `--measure-only`.
    #[schemars(with = "Option<f64>")]
    predicted: f64,
    /// The standard error of `predicted`, due to those of the spectrum and of the energies.
    #[schemars(with = "Option<f64>")]
    predicted_stderr: f64,
    /// The part of `predicted` beyond the largest degree or frequency of the spectrum.
    #[schemars(with = "Option<f64>")]
    predicted_tail: f64,
    /// The measured variance of the integral; null with `--predict-only`.
    #[schemars(with = "Option<f64>")]
    measured: f64,
    /// The standard error of `measured`.
    #[schemars(with = "Option<f64>")]
    measured_stderr: f64,
    /// Measured over predicted variance.
    #[schemars(with = "Option<f64>")]
    ratio: f64,
    /// The standard error of `ratio`.
    #[schemars(with = "Option<f64>")]
    ratio_stderr: f64,
    /// Measured minus predicted variance, in standard errors.
    #[schemars(with = "Option<f64>")]
    z: f64,
    /// The mean estimate of the integral over the trials.
    #[schemars(with = "Option<f64>")]
    mean: f64,
    /// The standard error of `mean`.
    #[schemars(with = "Option<f64>")]
    mean_stderr: f64,
    /// The exact integral; of an irradiance E, the norm `sqrt(int E^2)` over all normals.
    exact: Option<f64>,
    /// The predicted standard error, `sqrt(predicted)`, over `exact`; null for an integral of 0.
    relative_error: Option<f64>,
    /// The error of `predicted` due to degrees beyond the spectrum.
    #[schemars(with = "Option<f64>")]
    predicted_tail_error: f64,
    /// The lower end of the 95 % interval of the predicted variance.
    #[schemars(with = "Option<f64>")]
    predicted_low: f64,
    /// The upper end of the 95 % interval of the predicted variance.
    #[schemars(with = "Option<f64>")]
    predicted_high: f64,
    /// The lower end of the 95 % interval of the measured variance.
    #[schemars(with = "Option<f64>")]
    measured_low: f64,
    /// The upper end of the 95 % interval of the measured variance.
    #[schemars(with = "Option<f64>")]
    measured_high: f64,
    /// Mean minus exact integral, in standard errors.
    bias_z: Option<f64>,
    /// The probability of a `bias_z` of this size without a bias.
    bias_p: Option<f64>,
    /// The reason why numbers are missing.
    remark: Option<&'static str>,
    /// The effective number of weighted points, `(sum w)^2 / sum w^2`; null without weights, for
    /// warped patterns, whose weights differ from trial to trial, and with `--measure-only`.
    n_effective: Option<f64>,
    /// The largest known ratio of the integrand, weighted by the heuristic, and the density by which
    /// its points are distributed; this and the following are those of warped patterns only.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio: Option<f64>,
    /// The colatitude of `largest_ratio` in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio_theta: Option<f64>,
    /// The longitude of `largest_ratio` in degrees, from 0 to 360.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio_phi: Option<f64>,
    /// The number of the warp with `largest_ratio` in a sum of warps, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio_strategy: Option<usize>,
    /// The trials with a point whose ratio exceeds half of `largest_ratio`; this and the following
    /// are absent with `--predict-only`.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio_trials: Option<u64>,
    /// The expected number of such trials.
    #[serde(skip_serializing_if = "Option::is_none")]
    largest_ratio_expected: Option<f64>,
}

/// The remark of a row whose measured variance has no error estimate.
const TOO_FEW: &str = "too few trials hit the support of the integrand";

/// The remark of a row whose estimates are equal by rounding.
const ROUNDED_AWAY: &str = "rounding of the integrand's values hides its variance";

/// The confidence of the intervals in files.
const CONFIDENCE: f64 = 0.95;

impl RowRecord {
    pub(super) fn new(row: &Row) -> Self {
        let Comparison { prediction, measurement, .. } = &row.comparison;
        let is_measured = !measurement.estimates().is_empty();
        let (ratio, ratio_stderr) = row.comparison.ratio();
        let (predicted_low, predicted_high) = prediction.interval(CONFIDENCE);
        let measured = row.comparison.measured_interval(CONFIDENCE).filter(|_| is_measured);
        let (measured_low, measured_high) = measured.unwrap_or((f64::NAN, f64::NAN));
        let bias = row.comparison.bias();
        let bias = bias.filter(|_| !row.comparison.is_rounded_away() && is_measured);
        let is_rounded_away = row.comparison.is_rounded_away();
        let missing = match row.comparison.has_too_few_hits() {
            true => Some(TOO_FEW),
            false => is_rounded_away.then_some(ROUNDED_AWAY),
        };
        let missing = missing.filter(|_| is_measured);
        let remark = missing.or(row.is_unpredictable.then_some(UNPREDICTED));
        let of_trials = |x: f64| if is_rounded_away { f64::NAN } else { x };
        // The error of the trials does not include energy that they did not sample.
        let known = |x: f64| if missing.is_some() { f64::NAN } else { x };
        // An integral of 0 is known up to rounding.
        let error = prediction.variance.sqrt();
        let direction = row.largest.map(|largest| largest.direction);
        let watched = row.largest.filter(|_| is_measured);
        let exact = row.comparison.exact.filter(|exact| exact.abs() > 1e-10 * error);
        Self {
            integral: row.integral.clone(),
            relative_error: exact.map(|exact| error / exact.abs()).filter(|e| e.is_finite()),
            sampler: row.sampler.text.clone(),
            label: row.sampler.label.clone(),
            integrand: row.integrand.clone(),
            domain: row.domain.clone(),
            n_requested: row.requested,
            n: row.comparison.n_points,
            n_effective: row.n_effective,
            lmax: row.lmax,
            realizations: row.realizations,
            trials: measurement.estimates().len(),
            predicted: prediction.variance,
            predicted_stderr: prediction.stderr,
            predicted_tail: prediction.tail,
            measured: of_trials(measurement.variance()),
            measured_stderr: of_trials(known(
                measurement.variance() * row.comparison.error().relative(),
            )),
            ratio,
            ratio_stderr,
            z: of_trials(row.comparison.z_score()),
            mean: if is_measured { measurement.mean() } else { f64::NAN },
            mean_stderr: known(measurement.mean_stderr()),
            exact: row.comparison.exact,
            predicted_tail_error: prediction.tail_error,
            predicted_low,
            predicted_high,
            measured_low: of_trials(measured_low),
            measured_high: of_trials(measured_high),
            bias_z: bias.map(|b| b.z),
            bias_p: bias.map(|b| b.p_value),
            remark,
            largest_ratio: row.largest.map(|largest| largest.ratio),
            largest_ratio_theta: direction.map(|d| d.x.hypot(d.y).atan2(d.z).to_degrees()),
            largest_ratio_phi: direction
                .map(|d| d.y.atan2(d.x).rem_euclid(std::f64::consts::TAU).to_degrees()),
            largest_ratio_strategy: row.largest.map(|largest| largest.strategy + 1),
            largest_ratio_trials: watched.map(|largest| largest.trials),
            largest_ratio_expected: watched.map(|largest| largest.expected_trials),
        }
    }

    /// Returns the measured minus the predicted variance in standard errors; NaN without a verdict.
    pub(super) fn z(&self) -> f64 {
        self.z
    }

    /// Returns a line for every row whose measured variance has no error estimate.
    pub(super) fn remarks(records: &[Self]) -> String {
        let line = |r: &Self| {
            let of = r.integral.as_ref().map_or(String::new(), |name| format!(", {name}"));
            Some(format!("{}{of}, N = {}: {} (-m {}).\n", r.label, r.n, r.remark?, r.trials))
        };
        records.iter().filter_map(line).collect()
    }

    /// Returns the columns of a table of these records, which have predictions, measurements or both.
    pub(super) fn columns(records: &[Self], parts: Parts) -> Vec<Column<'static, Self>> {
        let mut columns = vec![
            Column::text("sampler", |r: &Self| r.label.clone()),
            Column::number("N requested", |r: &Self| r.n_requested.to_string()),
            Column::number("N", |r: &Self| r.n.to_string()),
        ];
        let has_several = records.iter().any(|r| r.integral.is_some());
        if has_several {
            let name = |r: &Self| r.integral.clone().unwrap_or_default();
            columns.insert(1, Column::text("integral", name));
        }
        if records.iter().any(|r| r.n_effective.is_some()) {
            let effective = |r: &Self| number::optional(r.n_effective, number::value);
            columns.push(Column::number("N_eff", effective));
        }
        if parts != Parts::Measured {
            columns.extend([
                Column::number("predicted", |r: &Self| number::value(r.predicted)),
                Column::number("+-", |r: &Self| {
                    number::uncertainty(r.predicted_stderr.hypot(r.predicted_tail_error))
                }),
            ]);
        }
        if parts != Parts::Predicted {
            columns.extend([
                Column::number("measured", |r: &Self| number::value(r.measured)),
                Column::number("+-", |r: &Self| number::uncertainty(r.measured_stderr)),
            ]);
        }
        if parts == Parts::Both {
            columns.extend([
                // A variance of 0 has no ratio.
                Column::number("ratio", |r: &Self| {
                    number::with_uncertainty(r.ratio, r.ratio_stderr)
                }),
                Column::number("z", |r: &Self| number::score(r.z)),
            ]);
        }
        if parts != Parts::Predicted {
            let bias = |r: &Self| number::optional(r.bias_z, number::score);
            columns.push(Column::number("bias z", bias));
        }
        if records.iter().any(|r| r.largest_ratio.is_some()) {
            let ratio = |r: &Self| number::optional(r.largest_ratio, number::value);
            columns.push(Column::number("max f/p", ratio));
            if parts != Parts::Predicted {
                columns.push(Column::number("trials near it (expected)", |r: &Self| {
                    let both = r.largest_ratio_trials.zip(r.largest_ratio_expected);
                    number::optional(both, |(trials, expected)| {
                        format!("{trials} ({})", number::count(expected))
                    })
                }));
            }
        }
        if has_several {
            let relative = |r: &Self| number::optional(r.relative_error, number::percent);
            columns.push(Column::number("relative error", relative));
        }
        columns
    }
}
