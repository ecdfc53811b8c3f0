//! Errors of patterns that are not rotated, for `variance --no-rotate`.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{Domain, Pattern};
use sphvar_variance::{FixedOrientation, trial_work};

use super::cases::Case;
use super::rows::{self, Plan};
use crate::error::CliError;
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};
use crate::progress::Progress;
use crate::report::{Column, number};

/// Errors of patterns that are not rotated: `variance --no-rotate --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FixedOrientationBody {
    /// Every sampler at every number of points.
    pub(super) rows: Vec<FixedOrientationRecord>,
}

/// The errors of a pattern at one number of points that is not rotated. A number that cannot be
/// given is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FixedOrientationRecord {
    /// The sampler with its parameters, as every command accepts it.
    sampler: String,
    /// The integrand, as it was given.
    integrand: String,
    /// `sphere` or `hemisphere`.
    domain: &'static str,
    /// The number of points requested.
    requested: usize,
    /// The number of points.
    n: usize,
    /// The largest degree of the spectrum.
    lmax: usize,
    /// What differs between trials: `orientation` for a set that is always the same, which the
    /// trials rotate uniformly; `realization` for a random pattern, which they do not rotate.
    varied: &'static str,
    /// The number of trials.
    trials: usize,
    /// The exact integral.
    exact: Option<f64>,
    /// The error of a set that is always the same, in its own orientation.
    signed_error: Option<f64>,
    /// The mean error of a random pattern over the trials: its bias in this orientation.
    mean_error: Option<f64>,
    /// The standard error of `mean_error`.
    mean_error_stderr: Option<f64>,
    /// The predicted variance over the trials.
    predicted: f64,
    /// The standard error of `predicted`, or the error of its quadrature.
    #[schemars(with = "Option<f64>")]
    predicted_stderr: f64,
    /// How `predicted` is computed: `rotated`, `isotropic` (independent points), `within-strata`
    /// (the sum of the variances in the strata), `all-sets` (given sets) or `linear-form`
    /// (realizations of the coefficients).
    predicted_method: &'static str,
    /// The terms of `predicted` with equal degrees and orders alone.
    predicted_diagonal: Option<f64>,
    /// The standard error of `predicted_diagonal`.
    predicted_diagonal_stderr: Option<f64>,
    /// The predicted variance of uniformly rotated realizations.
    predicted_rotated: f64,
    /// The standard error of `predicted_rotated`.
    #[schemars(with = "Option<f64>")]
    predicted_rotated_stderr: f64,
    /// The measured variance over the trials.
    #[schemars(with = "Option<f64>")]
    measured: f64,
    /// The standard error of `measured`.
    measured_stderr: Option<f64>,
    /// The lower end of the 95 % interval of the measured variance.
    measured_low: Option<f64>,
    /// The upper end of the 95 % interval of the measured variance.
    measured_high: Option<f64>,
    /// Measured over predicted variance.
    ratio: Option<f64>,
    /// The standard error of `ratio`.
    ratio_stderr: Option<f64>,
    /// Measured minus predicted variance, in standard errors.
    #[schemars(with = "Option<f64>")]
    z: f64,
    /// The standard deviation of the error over the trials, the square root of `measured`.
    #[schemars(with = "Option<f64>")]
    standard_deviation: f64,
    /// The square root of `predicted`.
    predicted_standard_deviation: f64,
    /// The error that 5 % of the trials do not exceed.
    error_q05: Option<f64>,
    /// The error that 25 % of the trials do not exceed.
    error_q25: Option<f64>,
    /// The median error.
    error_q50: Option<f64>,
    /// The error that 75 % of the trials do not exceed.
    error_q75: Option<f64>,
    /// The error that 95 % of the trials do not exceed.
    error_q95: Option<f64>,
    /// The largest error of a trial or in the own orientation of a set, with its sign.
    worst_error: Option<f64>,
}

/// The results of one case.
struct Row<'a> {
    pattern: &'a Pattern,
    record: FixedOrientationRecord,
}

/// Runs all cases and returns the rows in their order, with the chart; `None` if this run keeps only
/// a part of the work.
pub(super) fn run(
    plan: &Plan<'_>,
    cases: &[&Case],
) -> Result<Option<(FixedOrientationBody, Chart)>, CliError> {
    rows::check_uniform(plan, cases)?;
    let on_energies =
        |lmax: usize| plan.integrand.announce_energies(plan.domain, lmax, plan.effort.session);
    let mut predictor =
        plan.predictor_of(&*plan.integrand.function, plan.domain)?.on_energies(&on_energies);
    let effort = &plan.effort;
    let mut work = 0.0;
    for case in cases {
        let sampler = case.sampler();
        work += effort.trials_of::<Domain>(sampler).work(sampler);
        if effort.does_all() {
            work += predictor.work(sampler)?;
        }
    }
    let progress = Progress::new(work, effort.session);
    let known = effort.known(|| rows::known_of(&mut predictor, effort, cases))?;
    let mut rows = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        let (name, sampler) = (case.name(), case.sampler());
        progress.stage(&name);
        let prediction = effort.predicted(&name, || {
            effort.expect(&progress, predictor.work(sampler)?);
            Ok(predictor.predict_fixed_orientation(sampler, &progress)?)
        })?;
        let size = (effort.trials_of::<Domain>(sampler).count, trial_work(sampler));
        let compute = |range| Ok(predictor.fixed_orientation_estimates(sampler, range, &progress)?);
        let estimates = effort.estimates(&name, size, &progress, Vec::extend, compute)?;
        let experiment = known.as_ref().and_then(|known| known.experiments.get(i));
        if let (Some(prediction), Some(estimates), Some(experiment)) =
            (prediction, estimates, experiment)
        {
            let fixed = FixedOrientation::new(prediction, experiment, estimates);
            let record = FixedOrientationRecord::new(&fixed, case, plan);
            rows.push(Row { pattern: &case.pattern, record });
        }
    }
    drop(progress);
    if !effort.has_rows(&rows)? {
        return Ok(None);
    }
    let chart = chart(&rows, plan);
    let rows = rows.into_iter().map(|row| row.record).collect();
    Ok(Some((FixedOrientationBody { rows }, chart)))
}

impl FixedOrientationRecord {
    fn new(fixed: &FixedOrientation, case: &Case, plan: &Plan<'_>) -> Self {
        const CONFIDENCE: f64 = 0.95;
        let (predicted, predicted_stderr) = fixed.predicted();
        let measured = fixed.measurement.variance();
        let is_known = fixed.is_known();
        let relative = fixed.error().relative();
        let interval = fixed.measurement.variance_interval(CONFIDENCE).filter(|_| is_known);
        let ratio = Some(measured / predicted).filter(|r| is_known && r.is_finite());
        let mean = fixed.mean_error().filter(|_| fixed.unrotated.is_some());
        let diagonal = fixed.unrotated.and_then(|p| p.diagonal);
        let rotated = &fixed.rotated.prediction;
        let quantile = |p| fixed.error_quantile(p);
        Self {
            sampler: case.pattern.to_string(),
            integrand: plan.integrand.name.clone(),
            domain: plan.domain.name(),
            requested: case.requested,
            n: fixed.rotated.spectrum.n_points(),
            lmax: fixed.rotated.spectrum.lmax(),
            varied: if fixed.unrotated.is_some() { "realization" } else { "orientation" },
            trials: fixed.measurement.estimates().len(),
            exact: fixed.exact,
            signed_error: fixed.signed_error(),
            mean_error: mean.map(|m| m.0),
            mean_error_stderr: mean.map(|m| m.1),
            predicted,
            predicted_stderr,
            predicted_method: fixed.unrotated.map_or("rotated", |p| p.method.name()),
            predicted_diagonal: diagonal.map(|d| d.0),
            predicted_diagonal_stderr: diagonal.map(|d| d.1).filter(|e| e.is_finite()),
            predicted_rotated: rotated.variance,
            predicted_rotated_stderr: rotated.total_stderr(),
            measured,
            measured_stderr: Some(measured * relative).filter(|_| is_known),
            measured_low: interval.map(|i| i.0),
            measured_high: interval.map(|i| i.1),
            ratio,
            ratio_stderr: ratio.map(|r| r * relative.hypot(predicted_stderr / predicted)),
            z: fixed.z_score(),
            standard_deviation: measured.sqrt(),
            predicted_standard_deviation: predicted.sqrt(),
            error_q05: quantile(0.05),
            error_q25: quantile(0.25),
            error_q50: quantile(0.5),
            error_q75: quantile(0.75),
            error_q95: quantile(0.95),
            worst_error: fixed.worst_error(),
        }
    }

    /// Returns the error in this orientation: of the set, or the mean of a random pattern.
    fn error(&self) -> Option<f64> {
        self.signed_error.or(self.mean_error)
    }

    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        let value = |x| number::optional(x, number::value);
        vec![
            Column::text("sampler", |r: &Self| r.sampler.clone()),
            Column::number("N", |r: &Self| r.n.to_string()),
            Column::number("error", move |r: &Self| value(r.error())),
            Column::number("+-", |r: &Self| {
                number::optional(r.mean_error_stderr, number::uncertainty)
            }),
            Column::text("over", |r: &Self| format!("{}s", r.varied)),
            Column::number("predicted sd", |r: &Self| {
                number::value(r.predicted_standard_deviation)
            }),
            Column::number("sd", |r: &Self| number::value(r.standard_deviation)),
            Column::number("z", |r: &Self| number::score(r.z)),
            Column::number("5 %", move |r: &Self| value(r.error_q05)),
            Column::number("25 %", move |r: &Self| value(r.error_q25)),
            Column::number("median", move |r: &Self| value(r.error_q50)),
            Column::number("75 %", move |r: &Self| value(r.error_q75)),
            Column::number("95 %", move |r: &Self| value(r.error_q95)),
            Column::number("worst", move |r: &Self| value(r.worst_error)),
            Column::number("rotated sd", |r: &Self| number::value(r.predicted_rotated.sqrt())),
        ]
    }
}

/// Returns the chart of the errors against N, in units of the predicted standard deviation.
fn chart(rows: &[Row<'_>], plan: &Plan<'_>) -> Chart {
    let mut patterns: Vec<&Pattern> = Vec::new();
    for row in rows {
        if !patterns.contains(&row.pattern) {
            patterns.push(row.pattern);
        }
    }
    let series = patterns.iter().enumerate().map(|(rank, pattern)| {
        let of_pattern = rows.iter().filter(|row| row.pattern == *pattern);
        let shown = of_pattern.filter_map(|Row { record: r, .. }| {
            let scaled = |x: f64| x / r.predicted_standard_deviation;
            let point = (r.n as f64, scaled(r.error()?));
            let range = (scaled(r.error_q05?), scaled(r.error_q95?));
            point.1.is_finite().then_some((point, range))
        });
        let (points, ranges) = shown.unzip();
        Series {
            label: pattern.to_string(),
            points,
            spread: Spread::Ranges(ranges),
            style: Style::Markers,
            ink: Ink::Rank(rank),
        }
    });
    Chart {
        title: format!("Errors without rotation: {}", plan.integrand.name),
        x_label: "number of points N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel {
            y_label: "error / predicted standard deviation".to_owned(),
            y_scale: Scale::Linear,
            series: series.collect(),
            reference: Some(0.0),
            side_by_side: true,
        }],
        notes: vec![
            "Markers: the error in the given orientation, for random patterns the mean error."
                .to_owned(),
            "Bars: 5 to 95 % of the errors over orientations (fixed sets) or realizations \
             (random patterns)."
                .to_owned(),
        ],
    }
}
