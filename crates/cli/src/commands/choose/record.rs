//! The results of `choose`, for files and tables.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_variance::{PredictedVariance, RequiredPoints};

use super::benefit::DensityBenefit;
use super::candidate::TimedCandidate;
use super::choosable::{Choosable, Details};
use super::crossings::CrossingRecord;
use super::question::Question;
use super::reason::Reason;
use crate::report::{Column, number};

/// A sampler that was not considered.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct LeftOut {
    /// The sampler with its parameters.
    pub(super) sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    pub(super) label: String,
    /// Why.
    pub(super) reason: String,
}

/// A sampler with what it needs or achieves. A number that cannot be given is null.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(super) struct CandidateRecord {
    /// The place, from 1 for the best.
    pub(super) rank: usize,
    /// The sampler with its parameters, as every command accepts it.
    pub(super) sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    pub(super) label: String,
    /// The number of points needed, or the largest valid count within the sample budget.
    pub(super) n: Option<usize>,
    /// `predicted`, `extrapolated`, `out of reach`, `behind`: more than 4 times the points of the
    /// best, or `known integral`: the density is the integrand itself to 1 %, so the integral is
    /// known from its normalization.
    pub(super) basis: &'static str,
    /// The largest number of points tried that does not suffice.
    pub(super) too_few: Option<usize>,
    /// The predicted variance of the integral, in squared units of the integral.
    pub(super) variance: Option<f64>,
    /// The standard error of `variance`, due to those of the spectrum and of the energies;
    /// extrapolations do not have it.
    pub(super) variance_stderr: Option<f64>,
    /// The largest error of `variance` from degrees beyond the spectrum.
    pub(super) variance_tail_error: Option<f64>,
    /// The standard error of the integral, `sqrt(variance)`.
    pub(super) error: Option<f64>,
    /// `error` over the integral.
    pub(super) relative_error: Option<f64>,
    /// The variance of white noise with the same number of points, divided by this one.
    pub(super) variance_reduction: Option<f64>,
    /// The exponent b of the variance as N^b near this number of points.
    pub(super) rate: Option<f64>,
    /// The 95 % interval of `rate`.
    pub(super) rate_interval: Option<(f64, f64)>,
    /// The time to make a set, in seconds on one core; null for sets from files.
    pub(super) seconds_per_set: Option<f64>,
    /// Whether `seconds_per_set` is scaled from a smaller set.
    pub(super) seconds_are_scaled: bool,
    /// The time to make a set and to evaluate the integrand at all points, in seconds, with
    /// `--cost-per-sample`.
    pub(super) seconds_in_all: Option<f64>,
    /// The largest degree of the spectrum at `n`; of the square, also for a warped pattern, the
    /// largest frequency.
    pub(super) lmax: Option<usize>,
    /// Realizations from which the spectrum at `n` was estimated; 0 for a closed form.
    pub(super) realizations: Option<u64>,
    /// The degree up to which the pattern has no power at `n`, if it is made so.
    pub(super) last_empty_degree: Option<usize>,
    /// The effective number of weighted points, `(sum w)^2 / sum w^2`; null without weights.
    pub(super) n_effective: Option<f64>,
    /// The integrand, as it was given, or a channel of it.
    pub(super) integrand: String,
    /// Every prediction that was made.
    pub(super) curve: Vec<CurveRecord>,
    /// The errors of the coefficients, with `--project` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) coefficients: Option<Vec<CoefficientRecord>>,
}

/// The error of a coefficient in real spherical harmonics.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(super) struct CoefficientRecord {
    /// The degree.
    pub(super) l: usize,
    /// The order, negative for the sine.
    pub(super) m: i64,
    /// The exact coefficient.
    pub(super) exact: Option<f64>,
    /// The predicted variance.
    pub(super) variance: f64,
    /// The standard error, `sqrt(variance)`.
    pub(super) error: f64,
}

/// The prediction at one number of points.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(super) struct CurveRecord {
    /// The number of points.
    pub(super) n: usize,
    /// The predicted variance of the integral.
    pub(super) variance: f64,
    /// The standard error of `variance`, due to those of the spectrum and of the energies.
    #[schemars(with = "Option<f64>")]
    pub(super) variance_stderr: f64,
    /// The largest error of `variance` from degrees beyond the spectrum.
    #[schemars(with = "Option<f64>")]
    pub(super) variance_tail_error: f64,
}

/// Samplers ranked by the points required for an error, or by the error with given points:
/// `choose --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ChoiceBody {
    /// The integrand, as it was given.
    pub(super) integrand: String,
    /// `sphere`, `hemisphere` or `square`.
    pub(super) domain: String,
    /// The integral, exact or accurate to 0.1 %; null if it is unknown or 0; of an irradiance E, the
    /// norm `sqrt(int E^2)` over all normals.
    pub(super) integral: Option<f64>,
    /// The standard error requested, in units of the integral.
    pub(super) error_requested: Option<f64>,
    /// The sample budget of `-n`.
    pub(super) points_requested: Option<usize>,
    /// The largest number of points considered.
    pub(super) max_points: Option<usize>,
    /// The time to evaluate the integrand once, in seconds, with `--cost-per-sample`.
    pub(super) cost_per_sample: Option<f64>,
    /// The exact number of points that white noise needs for the error requested, also beyond
    /// `max_points`.
    pub(super) white_noise_points: Option<f64>,
    /// The samplers, the best first; after those for luminance, those for each channel.
    pub(super) rows: Vec<CandidateRecord>,
    /// Samplers that were not considered.
    pub(super) left_out: Vec<LeftOut>,
    /// Crossings of the predicted variance curves of the best samplers.
    pub(super) crossovers: Vec<CrossingRecord>,
    /// The reason why the recommended sampler suits the integrand; null for a warped one.
    pub(super) reason: Option<Reason>,
    /// What densities that resemble the integrand buy, where they were ranked beside uniform
    /// directions.
    pub(super) density_benefit: Option<DensityBenefit>,
    /// The recommendation with its reason, in a sentence.
    pub(super) recommendation: String,
}

impl CandidateRecord {
    /// Returns the record of a candidate, apart from its rank; `white` is the variance of white noise
    /// with a number of points.
    pub(super) fn new<P: Choosable>(
        candidate: &TimedCandidate<P>,
        details: &Details,
        question: &Question,
        predictor: &P::Predictor<'_>,
        white: &dyn Fn(usize) -> f64,
    ) -> Self {
        let answer = &candidate.answer;
        let (curve, n_points) = (&answer.curve, answer.n_points);
        let point = n_points.and_then(|n| curve.at(n)).map(P::Point::prediction);
        let rate = match answer.required {
            Some(RequiredPoints::Extrapolated { fit, .. }) => Some(fit),
            _ => n_points.and_then(|n| curve.rate_near(n)),
        };
        let variance = answer.variance.map(|v| v.0);
        let finite = |x: &f64| x.is_finite();
        let curve_point = |point: &P::Point| CurveRecord {
            n: point.n_points(),
            variance: point.prediction().variance,
            variance_stderr: point.prediction().stderr,
            variance_tail_error: point.prediction().tail_error,
        };
        // The variance of a constant is rounding error, so its variance reduction and rate are
        // meaningless.
        let varies = white(1) > 0.0;
        let (rate, white) = (rate.filter(|_| varies), n_points.map(white).filter(|_| varies));
        Self {
            rank: 0,
            sampler: curve.pattern().to_string(),
            label: curve.pattern().label(),
            integrand: question.integrand.clone(),
            n: n_points,
            n_effective: details.n_effective,
            basis: candidate.basis(),
            too_few: match answer.required {
                Some(RequiredPoints::Predicted { too_few, .. }) => too_few,
                _ => None,
            },
            variance,
            variance_stderr: point.map(|p| p.stderr).filter(finite),
            variance_tail_error: point.map(|p| p.tail_error).filter(finite),
            error: variance.map(f64::sqrt),
            relative_error: variance.and_then(|v| question.relative(v.sqrt())),
            variance_reduction: white.zip(variance).map(|(white, v)| white / v).filter(finite),
            rate: rate.map(|fit| fit.slope),
            rate_interval: rate.map(|fit| fit.interval).filter(|i| (i.1 - i.0).is_finite()),
            seconds_per_set: candidate.set_time.map(|m| m.seconds),
            seconds_are_scaled: candidate.set_time.is_some_and(|m| m.is_scaled),
            seconds_in_all: candidate.seconds_in_all,
            lmax: details.lmax,
            realizations: details.realizations,
            last_empty_degree: n_points
                .and_then(|n| P::last_empty_degree(curve.pattern(), n, predictor)),
            curve: curve.points().iter().map(curve_point).collect(),
            coefficients: None,
        }
    }

    /// Returns the columns of a table.
    pub(super) fn columns(question: &Question, records: &[&Self]) -> Vec<Column<'static, Self>> {
        let mut columns = vec![
            Column::text("sampler", |r: &Self| r.label.clone()),
            Column::number("N", Self::count),
        ];
        if records.iter().any(|r| r.n_effective.is_some()) {
            let effective = |r: &Self| number::optional(r.n_effective, number::value);
            columns.push(Column::number("N_eff", effective));
        }
        columns.extend([
            Column::number("error", |r: &Self| r.error_text(r.relative_error.or(r.error))),
            Column::number("+-", |r: &Self| r.error_text(r.unknown_error())),
            Column::number("reduction", |r: &Self| {
                number::optional(r.variance_reduction, number::ratio)
            }),
            Column::number("rate", |r: &Self| match r.variance {
                Some(v) if v <= 0.0 => "exact".to_owned(),
                _ => number::optional(r.rate, number::rate),
            }),
            Column::number("time/set", |r: &Self| {
                let scaled = if r.seconds_are_scaled { "~" } else { "" };
                number::optional(r.seconds_per_set, |s| scaled.to_owned() + &number::seconds(s))
            }),
        ]);
        if question.cost_per_sample.is_some() {
            columns.push(Column::number("time in all", |r: &Self| {
                number::optional(r.seconds_in_all, number::seconds)
            }));
        }
        columns.push(Column::text("basis", |r: &Self| r.basis.to_owned()));
        columns
    }

    /// Returns the number of points, marked where it is extrapolated.
    pub(super) fn count(&self) -> String {
        let approximate = if self.basis == "extrapolated" { "~" } else { "" };
        number::optional(self.n, |n| format!("{approximate}{n}"))
    }

    /// Returns an error of the integral, in percent where the integral is known.
    pub(super) fn error_text(&self, error: Option<f64>) -> String {
        let format = if self.relative_error.is_some() { number::percent } else { number::value };
        number::optional(error, format)
    }

    /// Returns the uncertainty of the error; the relative error of a square root is half that of
    /// its argument.
    fn unknown_error(&self) -> Option<f64> {
        let total = self.variance_stderr.zip(self.variance_tail_error).map(|(s, t)| s.hypot(t));
        let half = total.zip(self.variance).map(|(e, v)| 0.5 * e / v.max(e));
        let error = self.relative_error.or(self.error);
        error.zip(half).map(|(error, half)| error * half).filter(|e| e.is_finite())
    }
}
