//! The results of `progressive`, for files and tables.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_variance::ProgressivePoint;

use crate::patterns::SamplerName;
use crate::report::{Column, number};

/// The error of the first `n` points of a sequence. A number that cannot be given is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PrefixRecord {
    /// The sequence with its parameters, as every command accepts it.
    pub(super) sampler: String,
    /// The name of the sequence in tables.
    #[serde(skip)]
    pub(super) label: String,
    /// The integrand, as it was given.
    pub(super) integrand: String,
    /// The number of points of the prefix.
    pub(super) n: usize,
    /// The predicted variance of the integral, in squared units of the integral; null without
    /// rotations or shifts.
    pub(super) predicted: Option<f64>,
    /// The standard error of `predicted`, due to those of the spectrum and of the energies.
    pub(super) predicted_stderr: Option<f64>,
    /// The error of `predicted` due to degrees beyond the spectrum.
    pub(super) predicted_tail_error: Option<f64>,
    /// The measured variance of the integral: the mean squared error of the trials where the exact
    /// integral is known, otherwise their sample variance.
    pub(super) measured: Option<f64>,
    /// The standard error of `measured`.
    pub(super) measured_stderr: Option<f64>,
    /// The lower end of the 95 % interval of the measured variance.
    pub(super) measured_low: Option<f64>,
    /// The upper end of the 95 % interval of the measured variance.
    pub(super) measured_high: Option<f64>,
    /// Measured minus predicted variance, in standard errors.
    pub(super) z: Option<f64>,
    /// The mean estimate of the integral over the trials.
    pub(super) mean: Option<f64>,
    /// The standard error of `mean`.
    pub(super) mean_stderr: Option<f64>,
    /// The predicted standard error divided by that of the reference with as many points, or the
    /// most below that it has; null at numbers of points without a prediction of the reference.
    pub(super) factor: Option<f64>,
}

impl PrefixRecord {
    /// Returns the record without a factor.
    pub(super) fn new(sampler: &SamplerName, integrand: &str, point: &ProgressivePoint) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let ProgressivePoint { n_points, prediction, measurement } = point;
        let measured = measurement.as_ref();
        let of_trials =
            |x: f64| finite(x).filter(|_| measured.is_some_and(|m| !m.has_too_few_hits));
        Self {
            sampler: sampler.text.clone(),
            label: sampler.label.clone(),
            integrand: integrand.to_owned(),
            n: *n_points,
            predicted: finite(prediction.variance),
            predicted_stderr: finite(prediction.stderr),
            predicted_tail_error: finite(prediction.tail_error),
            measured: measured.and_then(|m| finite(m.variance)),
            measured_stderr: measured.and_then(|m| of_trials(m.stderr)),
            measured_low: measured.and_then(|m| m.interval).map(|ends| ends.0),
            measured_high: measured.and_then(|m| m.interval).map(|ends| ends.1),
            z: measured.and_then(|m| of_trials(m.z)),
            mean: measured.and_then(|m| finite(m.mean)),
            mean_stderr: measured.and_then(|m| of_trials(m.mean_stderr)),
            factor: None,
        }
    }

    /// Returns the predicted variance or, if it is unknown, the measured one.
    pub(super) fn variance(&self) -> Option<f64> {
        self.predicted.or(self.measured)
    }

    /// Returns the ratio of standard errors to that of a reference.
    pub(super) fn factor_to(&self, reference: Option<f64>) -> Option<f64> {
        let factor = (self.predicted? / reference?).sqrt();
        Some(factor).filter(|factor| factor.is_finite())
    }

    /// Returns the columns of a table, with the square roots of variances.
    pub(super) fn columns(has_factors: bool) -> Vec<Column<'static, Self>> {
        let root = |variance: Option<f64>| {
            number::optional(variance, |variance| number::value(variance.sqrt()))
        };
        // The error of a square root x is that of x^2 over 2x.
        let error = |variance: Option<f64>, stderr: Option<f64>| {
            let both = variance.zip(stderr);
            number::optional(both, |(variance, stderr)| {
                let error = if stderr == 0.0 { 0.0 } else { 0.5 * stderr / variance.sqrt() };
                number::uncertainty(error)
            })
        };
        let of_prediction = |r: &Self| Some(r.predicted_stderr?.hypot(r.predicted_tail_error?));
        let mut columns = vec![
            Column::text("sampler", |r: &Self| r.label.clone()),
            Column::number("N", |r: &Self| r.n.to_string()),
            Column::number("predicted", move |r: &Self| root(r.predicted)),
            Column::number("+-", move |r: &Self| error(r.predicted, of_prediction(r))),
            Column::number("measured", move |r: &Self| root(r.measured)),
            Column::number("+-", move |r: &Self| error(r.measured, r.measured_stderr)),
            Column::number("z", |r: &Self| number::optional(r.z, number::score)),
        ];
        if has_factors {
            let factor = |r: &Self| number::optional(r.factor, number::ratio);
            columns.push(Column::number("factor", factor));
        }
        columns
    }
}

/// The errors of all prefixes of a sequence in short.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SequenceRecord {
    /// The sequence with its parameters.
    pub(super) sampler: String,
    /// The name of the sequence in tables.
    #[serde(skip)]
    pub(super) label: String,
    /// The integrand, as it was given.
    pub(super) integrand: String,
    /// `sphere`, `hemisphere` or `square`.
    pub(super) domain: String,
    /// The exact integral.
    pub(super) exact: Option<f64>,
    /// The source of rate and factors: `predicted` or `measured` variances.
    pub(super) basis: &'static str,
    /// Realizations from which the variances were predicted.
    pub(super) realizations: u64,
    /// Trials from which the variances were measured.
    pub(super) trials: u64,
    /// The number of points of the longest prefix.
    pub(super) n: usize,
    /// The exponent b of the variance as N^b, from `first_n` on.
    pub(super) rate: Option<f64>,
    /// The 95 % interval of `rate`.
    pub(super) rate_interval: Option<(f64, f64)>,
    /// The smallest number of points to which rate, mean and largest factor refer.
    pub(super) first_n: usize,
    /// The factor of the longest prefix.
    pub(super) factor: Option<f64>,
    /// The number of factors from `first_n` on.
    pub(super) factors: usize,
    /// Their geometric mean.
    pub(super) mean_factor: Option<f64>,
    /// The largest of them.
    pub(super) worst_factor: Option<f64>,
    /// The number of points of the prefix with the largest factor.
    pub(super) worst_n: Option<usize>,
    /// The reason why numbers are missing.
    pub(super) remark: Option<&'static str>,
}

impl SequenceRecord {
    /// Returns the columns of a table.
    pub(super) fn columns(has_factors: bool) -> Vec<Column<'static, Self>> {
        let interval = |ends| number::interval(ends, number::rate);
        let factor = |x| number::optional(x, number::ratio);
        let mut columns = vec![
            Column::text("sampler", |s: &Self| s.label.clone()),
            Column::number("rate", |s: &Self| number::optional(s.rate, number::rate)),
            Column::number("95 %", move |s: &Self| interval(s.rate_interval)),
        ];
        if has_factors {
            columns.extend([
                Column::number("at N", |s: &Self| s.n.to_string()),
                Column::number("factor", move |s: &Self| factor(s.factor)),
                Column::number("mean factor", move |s: &Self| factor(s.mean_factor)),
                Column::number("worst factor", move |s: &Self| factor(s.worst_factor)),
                Column::number("at N", |s: &Self| number::optional(s.worst_n, |n| n.to_string())),
            ]);
        }
        columns
    }
}

/// The variance of a reference pattern with `n` points.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ReferenceRecord {
    /// The pattern with its parameters.
    pub(super) sampler: String,
    /// The integrand, as it was given.
    pub(super) integrand: String,
    /// The number of points.
    pub(super) n: usize,
    /// The predicted variance of the integral, within its errors that of `variance`.
    #[schemars(with = "Option<f64>")]
    pub(super) predicted: f64,
    /// The standard error of `predicted`, with the error due to degrees beyond the spectrum.
    #[schemars(with = "Option<f64>")]
    pub(super) predicted_stderr: f64,
}

/// Predicted and measured variances of all prefixes of sequences: `progressive --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ProgressiveBody {
    /// Every prefix of every sequence.
    pub(super) rows: Vec<PrefixRecord>,
    /// Every sequence over all its prefixes.
    pub(super) sequences: Vec<SequenceRecord>,
    /// The patterns with which sequences are compared, made for each of some numbers of points.
    pub(super) reference: Vec<ReferenceRecord>,
}
