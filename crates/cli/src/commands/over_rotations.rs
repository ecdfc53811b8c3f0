//! Variances over rotations of low discrepancy, for `variance --rotations`.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{Domain, RotationGroup, RotationPattern};
use sphvar_variance::{OverRotations, trial_work};

use super::cases::Case;
use super::rows::{self, Plan};
use crate::error::CliError;
use crate::patterns;
use crate::progress::Progress;
use crate::report::{Column, number};

/// The number of sets of rotations, from whose spread the error follows.
const REPLICATES: u64 = 8;

/// Variances over rotations of low discrepancy: `variance --rotations --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct OverRotationsBody {
    /// Every sampler at every number of points.
    pub(super) rows: Vec<OverRotationsRecord>,
}

/// The variance of a pattern over sets of rotations. A number that cannot be given is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct OverRotationsRecord {
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
    /// The pattern of rotations with its parameters.
    rotations: String,
    /// The number of rotations of a replicate.
    rotations_per_replicate: usize,
    /// The number of replicates, each multiplied by an independent uniform rotation.
    replicates: usize,
    /// The exact integral.
    exact: Option<f64>,
    /// The predicted variance.
    predicted: f64,
    /// The standard error of `predicted`.
    #[schemars(with = "Option<f64>")]
    predicted_stderr: f64,
    /// The mean squared error over all rotations.
    measured: f64,
    /// The standard error of `measured`, from the replicates.
    #[schemars(with = "Option<f64>")]
    measured_stderr: f64,
    /// The lower end of the 95 % interval of the measured variance.
    measured_low: Option<f64>,
    /// The upper end of the 95 % interval of the measured variance.
    measured_high: Option<f64>,
    /// Measured over predicted variance.
    ratio: Option<f64>,
    /// Measured minus predicted variance, in standard errors.
    #[schemars(with = "Option<f64>")]
    z: f64,
}

/// Runs all cases and returns the rows in their order; `None` if this run keeps only a part of the
/// work.
pub(super) fn run(
    text: &str,
    plan: &Plan<'_>,
    cases: &[&Case],
) -> Result<Option<OverRotationsBody>, CliError> {
    rows::check_uniform(plan, cases)?;
    let pattern: RotationPattern = patterns::parse_pattern(text, plan.effort.session)?;
    let on_energies =
        |lmax: usize| plan.integrand.announce_energies(plan.domain, lmax, plan.effort.session);
    let mut predictor =
        plan.predictor_of(&*plan.integrand.function, plan.domain)?.on_energies(&on_energies);
    let effort = &plan.effort;
    let mut samplers = Vec::new();
    let mut work = 0.0;
    for case in cases {
        let sampler = case.sampler();
        let trials = effort.trials_of::<Domain>(sampler).count;
        let count = usize::try_from(trials.div_ceil(REPLICATES)).unwrap_or(usize::MAX);
        let rotations = patterns::build(&pattern, count, RotationGroup, true)?;
        let trials = REPLICATES.saturating_mul(rotations.n_points() as u64);
        work += trials as f64 * trial_work(sampler);
        if effort.does_all() {
            work += predictor.work(sampler)?;
        }
        samplers.push((rotations, trials));
    }
    let progress = Progress::new(work, effort.session);
    let mut rows = Vec::new();
    for (case, (rotations, trials)) in cases.iter().zip(&samplers) {
        let (name, sampler) = (case.name(), case.sampler());
        progress.stage(&name);
        let predicted = effort.predicted(&name, || {
            let share = effort.share(&progress, predictor.work(sampler)?);
            let point = predictor.predict(sampler, &share)?;
            share.finish().map_err(CliError::failed)?;
            Ok((point, plan.integrand.function.exact(plan.domain)))
        })?;
        let size = (*trials, trial_work(sampler));
        let compute =
            |range| Ok(predictor.rotation_estimates(sampler, &**rotations, range, &progress)?);
        let estimates = effort.estimates(&name, size, &progress, Vec::extend, compute)?;
        if let (Some((point, exact)), Some(estimates)) = (predicted, estimates) {
            let patterns = (sampler, &**rotations);
            let measured = predictor.over_rotations_of(point, exact, patterns, &estimates)?;
            rows.push(OverRotationsRecord::new(&measured, &pattern, case, plan));
        }
    }
    Ok(effort.has_rows(&rows)?.then_some(OverRotationsBody { rows }))
}

impl OverRotationsRecord {
    fn new(
        measured: &OverRotations,
        rotations: &RotationPattern,
        case: &Case,
        plan: &Plan<'_>,
    ) -> Self {
        const CONFIDENCE: f64 = 0.95;
        let interval = measured.interval(CONFIDENCE);
        let prediction = measured.predicted.prediction;
        let variance = measured.variance();
        Self {
            sampler: case.pattern.to_string(),
            integrand: plan.integrand.name.clone(),
            domain: plan.domain.name(),
            requested: case.requested,
            n: measured.predicted.spectrum.n_points(),
            rotations: rotations.to_string(),
            rotations_per_replicate: measured.n_rotations,
            replicates: measured.replicates.len(),
            exact: measured.exact,
            predicted: prediction.variance,
            predicted_stderr: prediction.total_stderr(),
            measured: variance,
            measured_stderr: measured.stderr(),
            measured_low: interval.map(|i| i.0),
            measured_high: interval.map(|i| i.1),
            ratio: Some(variance / prediction.variance).filter(|ratio| ratio.is_finite()),
            z: measured.z_score(),
        }
    }

    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        vec![
            Column::text("sampler", |r: &Self| r.sampler.clone()),
            Column::number("N", |r: &Self| r.n.to_string()),
            Column::text("rotations", |r: &Self| {
                format!("{} x {} {}", r.replicates, r.rotations_per_replicate, r.rotations)
            }),
            Column::number("predicted", |r: &Self| number::value(r.predicted)),
            Column::number("measured", |r: &Self| {
                number::with_uncertainty(r.measured, r.measured_stderr)
            }),
            Column::number("ratio", |r: &Self| number::optional(r.ratio, number::value)),
            Column::number("z", |r: &Self| number::score(r.z)),
        ]
    }
}
