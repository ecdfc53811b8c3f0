//! Measures of sets of rotations.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{RotationSampler, RotationSet};
use sphvar_spectrum::{Moments, RotationQuality};

use super::{Case, RotationsArgs};
use crate::error::CliError;
use crate::global::Global;
use crate::progress::Progress;
use crate::report::{Column, number, table_of};

/// The degrees whose powers the table has.
const SHOWN_DEGREES: usize = 6;

/// Measures of patterns of rotations: `rotations --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MeasuresBody {
    /// The measures of each pattern at each number of rotations.
    pub(super) rows: Vec<MeasuresRecord>,
}

/// The measures of a pattern of rotations, means over its realizations.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MeasuresRecord {
    /// The pattern with its parameters.
    sampler: String,
    /// The number of rotations.
    n: usize,
    /// `(sum w)^2 / sum w^2`, the number of rotations of equal weight with the same noise.
    n_effective: f64,
    /// The number of realizations that were measured, 1 where all are the same.
    realizations: u64,
    /// The least angle between two rotations, in degrees; null for one.
    separation_degrees: Option<f64>,
    /// The largest angle from any rotation to the nearest one of the set, in degrees.
    covering_radius_degrees: f64,
    /// The largest degree up to which all functions have their means over SO(3), in every realization.
    exact_degree: usize,
    /// The power of each degree, from 0; 1 for independent uniform rotations.
    power: Vec<f64>,
    /// The standard errors of the powers; null for a single realization.
    power_stderr: Option<Vec<f64>>,
    /// The concentration of the function whose mean has the error; null without --kappa.
    kappa: Option<f64>,
    /// The root mean square error of the mean over a randomly rotated set, relative to the mean over SO(3);
    /// null without --kappa.
    error: Option<f64>,
}

impl MeasuresRecord {
    pub(super) fn new(
        case: &Case,
        args: &RotationsArgs,
        lmax: usize,
        global: &Global,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let sampler = case.pattern.to_string();
        progress.stage(&sampler);
        // No measure depends on a rotation of the set.
        let realizations = if case.sampler.is_random() { args.realizations } else { 1 };
        let ensemble = case.ensemble(args, global);
        let mut set = RotationSet::default();
        let (mut separation, mut covering) = (Moments::default(), Moments::default());
        let (mut effective, mut squared_error) = (Moments::default(), Moments::default());
        let mut powers = vec![Moments::default(); lmax + 1];
        let mut exact_degree = usize::MAX;
        for index in 0..realizations {
            ensemble.realize_into(index, &mut set, progress).map_err(CliError::failed)?;
            let quality = RotationQuality::new(&set, lmax, progress).map_err(CliError::failed)?;
            separation.push(quality.separation.unwrap_or(f64::NAN));
            covering.push(quality.covering_radius);
            effective.push(quality.n_effective);
            exact_degree = exact_degree.min(quality.exact_degree);
            powers.iter_mut().zip(&quality.power).for_each(|(all, p)| all.push(*p));
            if let Some(kappa) = args.kappa {
                let error = RotationQuality::matrix_fisher_error(&set, kappa, progress);
                squared_error.push(error.map_err(CliError::failed)?.powi(2));
            }
        }
        Ok(Self {
            sampler,
            n: case.sampler.n_points(),
            n_effective: effective.mean(),
            realizations,
            separation_degrees: (case.sampler.n_points() > 1)
                .then(|| separation.mean().to_degrees()),
            covering_radius_degrees: covering.mean().to_degrees(),
            exact_degree,
            power: powers.iter().map(Moments::mean).collect(),
            power_stderr: (realizations > 1)
                .then(|| powers.iter().map(Moments::standard_error).collect()),
            kappa: args.kappa,
            error: args.kappa.map(|_| squared_error.mean().sqrt()),
        })
    }
}

/// Returns the nominal work of the measures of a pattern.
pub(super) fn nominal_work(
    sampler: &dyn RotationSampler,
    args: &RotationsArgs,
    lmax: usize,
) -> f64 {
    let count = if sampler.is_random() { args.realizations } else { 1 };
    let n = sampler.n_points();
    count as f64 * (n as f64 + RotationQuality::nominal_work(n, lmax))
}

impl MeasuresBody {
    /// Returns the table.
    pub(super) fn text(&self) -> String {
        let degrees = self.rows.first().map_or(0, |row| row.power.len().saturating_sub(1));
        let headings: Vec<String> =
            (1..=degrees.min(SHOWN_DEGREES)).map(|l| format!("P({l})")).collect();
        let mut columns = vec![
            Column::text("rotations", |row: &MeasuresRecord| row.sampler.clone()),
            Column::number("N", |row: &MeasuresRecord| row.n.to_string()),
            Column::number("separation", |row: &MeasuresRecord| {
                number::optional(row.separation_degrees, number::value)
            }),
            Column::number("covering radius", |row: &MeasuresRecord| {
                number::value(row.covering_radius_degrees)
            }),
            Column::number("exact degree", |row: &MeasuresRecord| row.exact_degree.to_string()),
        ];
        for (k, heading) in headings.iter().enumerate() {
            columns.push(Column::number(heading, move |row: &MeasuresRecord| {
                let stderr = row.power_stderr.as_ref().map(|stderr| stderr[k + 1]);
                match stderr {
                    Some(stderr) => number::with_uncertainty(row.power[k + 1], stderr),
                    None => number::value(row.power[k + 1]),
                }
            }));
        }
        if self.rows.iter().any(|row| row.error.is_some()) {
            columns.push(Column::number("error", |row: &MeasuresRecord| {
                number::optional(row.error, number::percent)
            }));
        }
        let table = table_of(&columns, &self.rows);
        format!("{table}\nangles in degrees; -o FILE writes the rotations\n")
    }
}
