//! The results of `compare`, for files and tables.

use schemars::JsonSchema;
use serde::Serialize;

use crate::commands::crossovers::CrossoverRecord;
use crate::commands::row_record::RowRecord;
use crate::report::{Column, number};

/// The spectrum of a pattern at one degree.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct DegreeRecord {
    /// The sampler with its parameters.
    pub(super) sampler: String,
    /// The number of points.
    pub(super) n: usize,
    /// The degree.
    pub(super) l: usize,
    /// `l / sqrt(N)`.
    pub(super) omega: f64,
    /// The mean power; white noise has 1.
    pub(super) power: f64,
    /// The standard error of `power`; 0 for a closed form.
    #[schemars(with = "Option<f64>")]
    pub(super) stderr: f64,
}

/// A sampler over all its numbers of points.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SamplerRecord {
    /// The sampler with its parameters.
    pub(super) sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    pub(super) label: String,
    /// Whether it is a warped pattern.
    #[serde(skip)]
    pub(super) is_warped: bool,
    /// The source of rate and variance reduction, the more precise one at every N: `predicted`,
    /// `measured` or `both`.
    pub(super) basis: &'static str,
    /// The exponent b of the variance as N^b.
    pub(super) rate: Option<f64>,
    /// The 95 % interval of `rate`.
    pub(super) rate_interval: Option<(f64, f64)>,
    /// By how much the exponent changes from the smallest to the largest number of points.
    pub(super) rate_change: Option<f64>,
    /// The probability of such a change where the variance is a power of N, if that is measured.
    pub(super) rate_change_p: Option<f64>,
    /// Whether the change is significant: the exponent is not the asymptotic one yet.
    pub(super) pre_asymptotic: bool,
    /// The exponent of the predicted variance.
    pub(super) predicted_rate: Option<f64>,
    /// The exponent of the measured variance.
    pub(super) measured_rate: Option<f64>,
    /// The 95 % interval of `measured_rate`.
    pub(super) measured_rate_interval: Option<(f64, f64)>,
    /// The largest number of points, to which the fields below belong.
    pub(super) n: usize,
    /// The exact variance of white noise, of uniform density, divided by this one; null where the variance does not
    /// exceed the rounding error.
    pub(super) variance_reduction: Option<f64>,
    /// The standard error of `variance_reduction`.
    pub(super) variance_reduction_stderr: Option<f64>,
    /// The reduction of the measured variance, where enough trials sample the support of the
    /// integrand.
    pub(super) measured_variance_reduction: Option<f64>,
    /// The standard error of `measured_variance_reduction`.
    pub(super) measured_variance_reduction_stderr: Option<f64>,
    /// The effective power, that is the pattern's power weighted by the integrand's energies:
    /// the predicted variance divided by that of white noise. Of a warped pattern it is that ratio,
    /// with the effect of the density.
    #[schemars(with = "Option<f64>")]
    pub(super) effective_power: f64,
}

/// Predicted and measured variances of patterns, their rates and crossovers: `compare --json` and
/// comparison.json.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ComparisonBody {
    /// Every sampler at every number of points.
    pub(super) rows: Vec<RowRecord>,
    /// Every sampler over all its numbers of points.
    pub(super) samplers: Vec<SamplerRecord>,
    /// Significant crossings of variance curves.
    pub(super) crossovers: Vec<CrossoverRecord>,
}

impl SamplerRecord {
    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        let interval = |interval| number::interval(interval, number::rate);
        vec![
            Column::text("sampler", |s: &Self| s.label.clone()),
            Column::number("rate", |s: &Self| {
                number::optional(s.rate, number::rate) + if s.pre_asymptotic { " *" } else { "" }
            }),
            Column::number("95 %", move |s: &Self| interval(s.rate_interval)),
            // A measured rate is shown with its interval, because from few trials it is very
            // uncertain.
            Column::number("measured (95 %)", move |s: &Self| {
                let both = s.measured_rate.zip(s.measured_rate_interval);
                number::optional(both, |(rate, ends)| {
                    format!("{} ({})", number::rate(rate), interval(Some(ends)))
                })
            }),
            Column::number("at N", |s: &Self| s.n.to_string()),
            Column::number("effective power", |s: &Self| number::value(s.effective_power)),
            Column::number("reduction", |s: &Self| {
                let both = s.variance_reduction.zip(s.variance_reduction_stderr);
                number::optional(both, |(ratio, e)| number::with_uncertainty(ratio, e))
            }),
        ]
    }
}
